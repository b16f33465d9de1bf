"""Independent solution of collisions of N wet spheres in a plane (Davis 2023), in Cartesian coordinates.

It uses scipy's integrators and its own events, shares nothing with pywet and reads the same JSON descriptions. Simple
and slow: python -m reference_impl.spheres.spheres FILE.json
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import DOP853, LSODA, Radau
from scipy.optimize import brentq

from reference_impl.faults import Refused, border, reading, regular
from reference_impl.spheres.forces import accelerations

SOLVERS = {"dop853": DOP853, "radau": Radau, "lsoda": LSODA}
Pair = tuple[int, int]
SEGMENTS = 20000


def from_groups(d: dict[str, Any]) -> dict[str, Any]:
    """Return the description of the paper's three equal spheres, lengths in δ_12, speeds in v_n0, mass in reduced masses."""
    r = 1.0 / (2.0 * d.get("h_a", 0.01))
    t12, t23 = math.radians(d.get("theta12_deg", 45.0)), math.radians(d.get("theta23_deg", 0.0))
    viscosity = 1.0 / (6.0 * math.pi * (r / 2.0) ** 2 * d["St_n"])
    ca = d.get("Ca")
    gap = d.get("h23_0", 1.0)
    n = 2 if gap is None else 3  # without one there is no third sphere
    reach = 2.0 * r + (gap or 0.0)
    film = [[0.0, 1.0, d.get("d13", 1.0)], [1.0, 0.0, d.get("d23", 1.0)], [d.get("d13", 1.0), d.get("d23", 1.0), 0.0]]
    return {
        "radius": [r] * n,
        "mass": [2.0] * n,
        "x": [[-(2.0 * r + 1.0) * math.cos(t12), -(2.0 * r + 1.0) * math.sin(t12)], [0.0, 0.0],
              [reach * math.cos(t23), reach * math.sin(t23)]][:n],
        "v": [[1.0 / math.cos(t12), 0.0], [0.0, 0.0], [0.0, 0.0]][:n],
        "spin": [0.0] * n,
        "film": [row[:n] for row in film[:n]],
        "viscosity": viscosity,
        "tension": 0.0 if ca is None else 3.0 * viscosity * (r / 2.0) / ca,
        "h_min": d.get("h_min", 0.05), "e": d.get("e_dry", 1.0), "mu": d.get("mu_f", 0.0), "g": [0.0, 0.0],
        "t_end": d.get("t_end", 400.0), "speed": 1.0,
    }  # fmt: skip


def from_spheres(d: dict[str, Any]) -> dict[str, Any]:
    """Read the description of wet spheres in SI units."""
    s = d["spheres"]
    return {
        "radius": [k["radius_m"] for k in s],
        "mass": [k["mass_kg"] for k in s],
        "x": [k["position_m"] for k in s],
        "v": [k.get("velocity_m_per_s", [0.0, 0.0]) for k in s],
        "spin": [k.get("omega_rad_per_s", 0.0) for k in s],
        "film": [[a["film_m"] + b["film_m"] for b in s] for a in s],
        "viscosity": d["viscosity_Pa_s"],
        "tension": d.get("surface_tension_N_per_m", 0.0),
        "h_min": d["h_min_m"],
        "e": d.get("e_dry", 1.0),
        "mu": d.get("mu_f", 0.0),
        "g": d.get("gravity_m_per_s2", [0.0, 0.0]),
        "t_end": d["t_end_s"],
        "speed": None,
    }


class Collision:
    """State and history of one collision."""

    def __init__(self, given: dict[str, Any], solver: str, rtol: float) -> None:
        self.given, self.rtol, self.method = given, rtol, SOLVERS[solver]
        self.radius, self.mass = np.array(given["radius"], float), np.array(given["mass"], float)
        self.film, self.g = np.array(given["film"], float), np.array(given["g"], float)
        n = self.n = self.radius.size
        self.y = np.zeros(5 * n + 3)
        for i in range(n):
            self.y[5 * i : 5 * i + 5] = [*given["x"][i], *given["v"][i], given["spin"][i]]
        self.t, self.impact = 0.0, 0.0
        self.pairs = [(i, j) for i in range(n) for j in range(i + 1, n)]
        self.wet = np.zeros((n, n), dtype=np.bool_)
        self.resting: set[Pair] = set()
        self.log: list[tuple[float, str, Pair, float]] = []
        self.length = float(max(self.film[p] for p in self.pairs))
        apart = [float(np.hypot(*(self.velocity(self.y, i) - self.velocity(self.y, j)))) for i, j in self.pairs]
        self.speed = given["speed"] or max(apart) or 1.0
        for p in self.pairs:
            gap, closing = self.gap(self.y, p), self.closing(self.y, p)
            tolerance = 1e-9 * self.length
            if gap < self.film[p] - tolerance or (gap < self.film[p] + tolerance and closing > -1e-12 * self.speed):
                self.wet[p] = True
                self.log.append((0.0, "overlap", p, closing))

    def velocity(self, y: np.ndarray, i: int) -> np.ndarray:
        """Return the velocity of sphere i."""
        return y[5 * i + 2 : 5 * i + 4]

    def normal(self, y: np.ndarray, p: Pair) -> np.ndarray:
        """Return the unit vector from the first to the second sphere."""
        d = y[5 * p[1] : 5 * p[1] + 2] - y[5 * p[0] : 5 * p[0] + 2]
        return d / np.hypot(*d)

    def gap(self, y: np.ndarray, p: Pair) -> Any:
        """Return the gap between the surfaces; for many states if y is (size, times)."""
        d = y[5 * p[1] : 5 * p[1] + 2] - y[5 * p[0] : 5 * p[0] + 2]
        return np.sqrt(d[0] ** 2 + d[1] ** 2) - self.radius[p[0]] - self.radius[p[1]]

    def closing(self, y: np.ndarray, p: Pair) -> float:
        """Return the normal speed of approach of a pair."""
        return float((self.velocity(y, p[0]) - self.velocity(y, p[1])) @ self.normal(y, p))

    def kinetic(self) -> float:
        """Return the kinetic energy, including spin."""
        s = self.y[: 5 * self.n].reshape(self.n, 5)
        return float(0.5 * self.mass @ (s[:, 2] ** 2 + s[:, 3] ** 2 + 0.4 * (self.radius * s[:, 4]) ** 2))

    def free(self, y: np.ndarray) -> Any:
        """Return the right-hand side without the forces of resting contacts."""
        viscosity, tension, h_min = (self.given[name] for name in ("viscosity", "tension", "h_min"))
        return accelerations(y, self.radius, self.mass, self.film, self.wet, viscosity, tension, h_min, self.g)

    def rate(self, t: float, y: np.ndarray) -> Any:
        """Return the right-hand side; the forces of resting contacts are never tensile and prevent approach."""
        r = self.free(y)
        if self.resting:
            self.push(y, r)
        return r

    def push(self, y: np.ndarray, r: np.ndarray) -> np.ndarray:
        """Add the normal forces (no friction) of resting contacts to r and return them."""
        held = sorted(self.resting)
        normals = [self.normal(y, p) for p in held]
        jacobian = np.zeros((len(held), 2 * self.n))
        for k, (i, j) in enumerate(held):
            jacobian[k, 2 * i : 2 * i + 2], jacobian[k, 2 * j : 2 * j + 2] = normals[k], -normals[k]
        acceleration = r[: 5 * self.n].reshape(self.n, 5)[:, 2:4].ravel()
        turning = []
        for k, (i, j) in enumerate(held):
            v = self.velocity(y, i) - self.velocity(y, j)
            across = v - (v @ normals[k]) * normals[k]
            turning.append(float(across @ across) / (self.gap(y, (i, j)) + self.radius[i] + self.radius[j]))
        inverse = np.repeat(1.0 / self.mass, 2)
        force = np.linalg.lstsq(
            jacobian * inverse @ jacobian.T, jacobian @ acceleration - np.array(turning), rcond=None
        )[0]
        change = -(jacobian.T @ force) * inverse
        for i in range(self.n):
            r[5 * i + 2 : 5 * i + 4] += change[2 * i : 2 * i + 2]
        return force

    def strike(self, p: Pair, e: float) -> None:
        """Apply the impulses of an impact to velocities and spins."""
        i, j = p
        n = self.normal(self.y, p)
        t = np.array([-n[1], n[0]])
        reduced = self.mass[i] * self.mass[j] / (self.mass[i] + self.mass[j])
        v = self.velocity(self.y, i) - self.velocity(self.y, j)
        jn = (1.0 + e) * reduced * float(v @ n)
        slip = float(v @ t) + self.radius[i] * self.y[5 * i + 4] + self.radius[j] * self.y[5 * j + 4]
        jt = math.copysign(min(self.given["mu"] * abs(jn), 2.0 * reduced * abs(slip) / 7.0), slip)
        before = self.kinetic()
        for k, sign in ((i, -1.0), (j, 1.0)):
            self.y[5 * k + 2 : 5 * k + 4] += sign * (jn * n + jt * t) / self.mass[k]
            self.y[5 * k + 4] -= jt / (0.4 * self.mass[k] * self.radius[k])
        self.impact += before - self.kinetic()

    def settle(self) -> None:
        """Apply the impacts of this instant, the fastest first; slow compressed ones come to rest."""
        for k in range(1000):
            near = [
                p for p in self.pairs if self.wet[p] and self.gap(self.y, p) < self.given["h_min"] + 1e-9 * self.length
            ]
            speeds = {p: self.closing(self.y, p) for p in near}
            p = max(speeds, key=lambda q: speeds[q], default=None)
            if p is None or speeds[p] <= 1e-10 * self.speed:
                break
            slow = self.given["e"] * speeds[p] < 1e-5 * self.speed or k > 500
            self.resting.discard(p)
            self.log.append((self.t, "rest" if slow else "contact", p, speeds[p]))
            self.strike(p, 0.0 if slow else self.given["e"])
            if slow:
                self.resting.add(p)
        self.resting = {p for p in self.resting if self.closing(self.y, p) > -1e-9 * self.speed}
        while self.resting:
            held = sorted(self.resting)
            force = self.push(self.y, self.free(self.y))
            if force.min() >= 0.0:
                break
            self.resting.discard(held[int(force.argmin())])

    def measures(self) -> list[tuple[str, Pair, Any]]:
        """Return the events to be detected: (kind, pair, function of y that falls through 0 at the event)."""
        found: list[tuple[str, Pair, Any]] = []
        for p in self.pairs:
            if p in self.resting:
                index = sorted(self.resting).index(p)
                found.append(("release", p, lambda y, k=index: self.force_of(y, k)))
            elif self.wet[p]:
                found.append(("contact", p, lambda y, p=p: self.gap(y, p) - self.given["h_min"]))
                found.append(("separation", p, lambda y, p=p: self.film[p] - self.gap(y, p)))
            else:
                found.append(("overlap", p, lambda y, p=p: self.gap(y, p) - self.film[p]))
        return found

    def force_of(self, y: np.ndarray, k: int) -> Any:
        """Return the normal force of the k-th resting contact; for many states if y is (size, times)."""
        if y.ndim == 2:
            return [self.force_of(s, k) for s in y.T]
        return float(self.push(y, self.free(y))[k])

    def segment(self) -> None:
        """Integrate to the next event or to the end."""
        scale = np.tile([self.length, self.length, self.speed, self.speed, self.speed / self.radius.max()], self.n)
        energy = float(self.mass.min()) * self.speed**2
        atol = self.rtol * np.append(scale, [energy] * 3)
        solver = self.method(
            self.rate, self.t, self.y, self.given["t_end"], rtol=min(self.rtol, 1e-9), atol=atol,
            max_step=20.0 * self.length / self.speed, first_step=None,
        )  # fmt: skip
        watch = self.measures()
        floor = 1e-11 * self.length
        while solver.status == "running":
            solver.step()
            if solver.status == "failed":
                raise ArithmeticError(f"the integrator gave up at t = {solver.t}")
            path, times = solver.dense_output(), np.linspace(solver.t_old, solver.t, 13)
            first: tuple[float, str, Pair] | None = None
            for kind, p, value in watch:
                v = np.asarray(value(path(times)))
                below = (v[1:] < (-floor if kind != "release" else 0.0)) & ((v[:-1] >= 0.0) | (v[1:] < v[:-1]))
                if below.any():
                    k = int(below.argmax())
                    fine = np.linspace(times[k], times[k + 1], 200)
                    f = np.asarray(value(path(fine)))  # a bounce may begin and end within this interval
                    top = int(f.argmax())
                    at = fine[top]
                    if f[top] > 0.0:
                        at = brentq(lambda t, f=value, path=path: float(f(path(t))), at, fine[-1], xtol=1e-15)
                    first = (at, kind, p) if first is None or at < first[0] else first
            if first is not None:
                self.t, self.y = first[0], path(first[0])
                self.happen(first[1], first[2])
                return
        self.t, self.y = solver.t, solver.y

    def happen(self, kind: str, p: Pair) -> None:
        """Apply an event to the state; impacts follow in `settle`."""
        if kind != "contact":
            self.log.append((self.t, kind, p, self.closing(self.y, p)))
        if kind in ("overlap", "separation"):
            self.wet[p] = kind == "overlap"
        if kind == "release":
            self.resting.discard(p)

    def solve(self) -> dict[str, Any]:
        """Integrate the collision to its end."""
        start = self.kinetic()
        for _ in range(SEGMENTS):
            if self.t >= self.given["t_end"]:
                break
            self.settle()
            self.segment()
        else:
            raise ArithmeticError(f"more than {SEGMENTS} events by t = {self.t}")
        state = self.y[: 5 * self.n].reshape(self.n, 5)
        viscous, capillary, gravity = self.y[5 * self.n :]
        out = self.kinetic()
        return {
            "events": [(t, kind, (i + 1, j + 1), u) for t, kind, (i, j), u in self.log],
            "stuck_pairs": [[i + 1, j + 1] for i, j in self.pairs if self.wet[i, j]],
            "final": {"position": state[:, :2], "velocity": state[:, 2:4], "omega": state[:, 4]},
            "energy": {
                "in": start, "out": out, "viscous": viscous, "capillary": capillary, "impact": self.impact, "gravity": gravity,
                "residual": start + gravity - out - viscous - capillary - self.impact,
            },
        }  # fmt: skip


def solve(description: dict[str, Any], solver: str = "dop853", rtol: float = 1e-11) -> dict[str, Any]:
    """Return events, final state and energies of a collision described as for `pywet collide spheres`."""
    forms = {"three_equal_spheres": from_groups, "spheres": from_spheres}
    return Collision(forms[description["form"]](description), solver, rtol).solve()


def main() -> int:
    """Solve one file and print JSON."""
    if len(sys.argv) != 2:
        raise Refused(f"{len(sys.argv) - 1} arguments were given; expected FILE.json")
    with reading(sys.argv[1], "a collision as docs/sphere_collisions.md describes it, in JSON"):
        answer = solve(json.loads(regular(Path(sys.argv[1])).read_text()))
    print(json.dumps(answer, indent=2, default=lambda a: a.tolist()))
    return 0


if __name__ == "__main__":
    with border(1):
        sys.exit(main())
