"""Statements of Elskamp & Kruggel-Emden (2018) on their simulations in sections 5.2 and 5.3, as numbers with ranges.

Y, U, t and shares as in `quantities`. The words of the text stand for the same ranges everywhere:

=====================  ======================================================================
very similar           largest difference of two curves below 0.05 of the feed
similar                difference below 0.03 of the feed
slightly, low          mean difference between 0 and 0.05 of the feed
much                   mean difference above 0.05 of the feed
in most, in some       more than half of the cases; at least one and not all
about a time t         from two thirds to 1.2 t for "about 15 s", ± 2 s for "until 7 s"
nearly equal           within 25 %
nearly all             98 %
nearly an equilibrium  a tenth of the change before
slightly more          between 1 and 1.2 times
=====================  ======================================================================

Statements of sections 3 and 4, on laws alone, are in `law_statements`.
"""

from __future__ import annotations

from studies.full_scale import quantities as q
from studies.full_scale.judging import Statement, above, below, within
from studies.full_scale.law_statements import LAW_STATEMENTS, larger_gets, wall_gets
from studies.full_scale.stored_runs import COARSE

DRY = {1: (2, 3), 4: (5, 6), 7: (8, 9), 10: (11, 12), 13: (14, 15), 16: (17, 18)}
"""Dry case -> its moist ones, less liquid first."""
MOIST = {moist: dry for dry, pair in DRY.items() for moist in pair}
EARLIER = "61b2a5eea1730cb2"
"""Digest of the statements when the stored runs ended.

Since then those on pegging (4, 15) count spheres that stay in an aperture (`StoredRun.pegged`), 4 per aperture; before, they
counted all that were slower than half the screen at an output, also those that turn around.
"""
ONE_MM = (1, 2, 3, 7, 8, 9, 10, 11, 12, 16, 17, 18)
"""Cases of Fig. 13."""

# fmt: off
STATEMENTS: tuple[Statement, ...] = (
    Statement(1, "5.2, Fig. 10a", "POM, 8 mm, 1 mm, dry: fast reduction until all undersize is through at about 15 s.", (1,), (
        within("t at U < 0.01 [s]", 10.0, 18.0, lambda c: q.through(c, 1, 0.01)),
    )),
    Statement(2, "5.2, Fig. 10a", "An amplitude of 0.8 mm passes more slowly after 5 s.", (1, 4), (
        within("mean Y4 − Y1, 5 to 15 s", 0.005, 0.05, lambda c: q.gap(c, 4, 1, 5.0, 15.0)),
        below("|mean Y4 − Y1, 1 to 5 s|", 0.03, lambda c: abs(q.gap(c, 4, 1, 1.0, 5.0))),
    )),
    Statement(3, "5.2, Fig. 10a", "5.6 mm POM falls fast in the first 2 s, then more slowly and longer than 8 mm.", (1, 7), (
        within("share of the undersize through in the first 2 s, case 7", 0.3, 0.9, lambda c: 1.0 - q.undersize(c, 7, 2.0)),
        below("through from 2 to 4 s over that, case 7", 0.5,
              lambda c: (q.undersize(c, 7, 2.0) - q.undersize(c, 7, 4.0)) / (1.0 - q.undersize(c, 7, 2.0))),
        above("U7 − U1 at 10 s", 0.02, lambda c: q.undersize(c, 7, 10.0) - q.undersize(c, 1, 10.0)),
    )),
    Statement(4, "5.2, Fig. 10a", "With 5.6 mm the large spheres peg the apertures more than with 8 mm.", (1, 7), (
        above("pegged large spheres per aperture, case 7 over case 1", 1.2, lambda c: q.pegged_ratio(c, 7, 1)),
    )),
    Statement(5, "5.2, Fig. 10b",
              "Dry glass is very similar to POM; with 5.6 mm slightly more retarded.", (1, 4, 7, 10, 13, 16), (
        below("largest |Y10 − Y1|", 0.05, lambda c: max(q.largest(c, 10, None, 1, None), q.largest(c, 1, None, 10, None))),
        below("largest |Y13 − Y4|", 0.05, lambda c: max(q.largest(c, 13, None, 4, None), q.largest(c, 4, None, 13, None))),
        within("mean Y16 − Y7, 2 to 20 s", 0.0, 0.05, lambda c: q.gap(c, 16, 7, 2.0, 20.0)),
    )),
    Statement(6, "6",
              "Y is slightly lower with 1 mm than with 0.8 mm, and much lower for 8 mm than for 5.6 mm.", (1, 4, 7, 10, 13, 16), (
        within("mean Y4 − Y1, 2 to 20 s", 0.0, 0.05, lambda c: q.gap(c, 4, 1, 2.0, 20.0)),
        within("mean Y13 − Y10, 2 to 20 s", 0.0, 0.05, lambda c: q.gap(c, 13, 10, 2.0, 20.0)),
        above("mean Y7 − Y1, 5 to 20 s", 0.05, lambda c: q.gap(c, 7, 1, 5.0, 20.0)),
        above("mean Y16 − Y10, 5 to 20 s", 0.05, lambda c: q.gap(c, 16, 10, 5.0, 20.0)),
    )),
    Statement(7, "5.2, Fig. 12a", "POM, 8 mm, 1 mm: 5 % of liquid reduces the passage, 10 % does not further.", (1, 2, 3), (
        within("mean Y2 − Y1, 2.5 to 10 s", 0.005, 0.05, lambda c: q.gap(c, 2, 1, 2.5, 10.0)),
        below("|Y3 − Y2| − (Y2 − Y1)/2, means 2.5 to 10 s", 0.0,
              lambda c: abs(q.gap(c, 3, 2, 2.5, 10.0)) - 0.5 * q.gap(c, 2, 1, 2.5, 10.0)),
    )),
    Statement(8, "5.2, Fig. 12b", "POM, 8 mm, 0.8 mm: Y is higher with liquid; simulated, slightly higher still with 10 %.",
              (4, 5, 6), (
        above("mean Y5 − Y4, 2 to 15 s", 0.0, lambda c: q.gap(c, 5, 4, 2.0, 15.0)),
        within("mean Y6 − Y5, 2 to 15 s", 0.0, 0.05, lambda c: q.gap(c, 6, 5, 2.0, 15.0)),
    )),
    Statement(9, "5.2, Fig. 12c",
              "POM, 5.6 mm: until 20 s 5 % of liquid retards, 10 % more, and more than at 8 mm.", (1, 3, 7, 8, 9), (
        above("mean Y8 − Y7, 1 to 10 s", 0.0, lambda c: q.gap(c, 8, 7, 1.0, 10.0)),
        above("mean Y8 − Y7, 10 to 19 s", 0.0, lambda c: q.gap(c, 8, 7, 10.0, 19.0)),
        above("mean Y9 − Y8, 1 to 20 s", 0.0, lambda c: q.gap(c, 9, 8, 1.0, 20.0)),
        above("(Y9 − Y7) − (Y3 − Y1), means 1 to 10 s", 0.0, lambda c: q.gap(c, 9, 7, 1.0, 10.0) - q.gap(c, 3, 1, 1.0, 10.0)),
    )),
    Statement(10, "5.2, Fig. 12c", "At 20 s Y is similar for 0 and 5 % and only slightly larger for 10 %.", (7, 8, 9), (
        below("|Y8 − Y7| at the end", 0.03, lambda c: abs(q.gap(c, 8, 7, 19.5, 20.0))),
        within("Y9 − Y7 at the end", 0.0, 0.05, lambda c: q.gap(c, 9, 7, 19.5, 20.0)),
    )),
    Statement(11, "5.2, Fig. 12d", "Glass, 8 mm, 1 mm: Y rises with the liquid; the influence is low.", (10, 11, 12), (
        within("mean Y11 − Y10, 2 to 10 s", 0.0, 0.05, lambda c: q.gap(c, 11, 10, 2.0, 10.0)),
        within("mean Y12 − Y11, 2 to 10 s", 0.0, 0.05, lambda c: q.gap(c, 12, 11, 2.0, 10.0)),
        below("mean Y12 − Y10, 2 to 20 s", 0.05, lambda c: q.gap(c, 12, 10, 2.0, 20.0)),
    )),
    Statement(12, "5.2, Fig. 12e", "Glass, 0.8 mm: the same trend, closer together.", (10, 11, 12, 13, 14, 15), (
        above("mean Y14 − Y13, 2 to 10 s", 0.0, lambda c: q.gap(c, 14, 13, 2.0, 10.0)),
        above("mean Y15 − Y14, 2 to 10 s", 0.0, lambda c: q.gap(c, 15, 14, 2.0, 10.0)),
        below("spread of 13–15 − that of 10–12", 0.0, lambda c: q.spread(c, (13, 14, 15)) - q.spread(c, (10, 11, 12))),
    )),
    Statement(13, "5.2, Fig. 12f", "5.6 mm: liquid influences glass less than POM.", (7, 8, 9, 16, 17, 18), (
        below("spread of 16–18 − that of 7–9 while liquid retards, 1 to 5 s", 0.0,
              lambda c: q.spread(c, (16, 17, 18), 1.0, 5.0) - q.spread(c, (7, 8, 9), 1.0, 5.0)),
    )),
    Statement(14, "5.2, Fig. 12f", "Glass, 5.6 mm: at 20 s less remains when moist, as dry spheres peg.", (16, 17, 18), (
        below("Y17 − Y16 at the end", 0.0, lambda c: q.gap(c, 17, 16, 19.5, 20.0)),
        below("Y18 − Y16 at the end", 0.0, lambda c: q.gap(c, 18, 16, 19.5, 20.0)),
    )),
    Statement(15, "6",
              "Liquid slightly reduces the passage in most configurations, and pegging in some.", tuple(range(1, 19)), (
        above("moist cases of 12 with a mean Y higher by 0 to 0.05, 0 to 20 s", 6.5,
              lambda c: sum(0.0 < q.gap(c, m, d, 0.0, 20.0) < 0.05 for m, d in MOIST.items())),
        within("moist cases of 12 with fewer pegged large spheres, by one or more", 0.5, 11.5,
               lambda c: sum(q.pegged(c, m) <= q.pegged(c, d) - q.ONE_SPHERE for m, d in MOIST.items())),
    )),
    Statement(16, "5.2, Fig. 13", "In most cases small spheres pass faster than near-mesh ones.", ONE_MM, (
        above("cases of 12 with mean Y_small < Y_near, 1 to 10 s", 6.5,
              lambda c: sum(q.lag(c[k], 1.0, 10.0) < 0 for k in ONE_MM)),
    )),
    Statement(17, "5.2, Fig. 13a", "POM, 8 mm, 10 %: small spheres are slower until about 7 s, then as expected.", (3,), (
        above("mean Y_small − Y_near, 1 to 5 s", 0.0, lambda c: q.lag(c[3], 1.0, 5.0)),
        within("last time at which Y_small > Y_near [s]", 5.0, 9.0, lambda c: q.last_lag(c[3])),
    )),
    Statement(18, "5.2, Fig. 13b", "POM, 5.6 mm: small before near-mesh at every liquid amount.", (7, 8, 9), (
        below("largest mean Y_small − Y_near of cases 7 to 9, 1 to 20 s", 0.0,
              lambda c: max(q.lag(c[k], 1.0, 20.0) for k in (7, 8, 9))),
    )),
    Statement(19, "5.2, Fig. 13b", "POM, 5.6 mm, dry: after a while both undersize classes are hindered.", (7, 8, 9), tuple(
        above(f"fall of Y_{name} from 5 to 20 s, case {k} − case 7", 0.0,
              lambda c, k=k, kind=kind: q.fall(c[k], kind) - q.fall(c[7], kind))  # type: ignore[misc]
        for k in (8, 9) for name, kind in (("small", q.SMALL), ("near", q.NEAR))
    )),
    Statement(20, "5.2, Fig. 13b",
              "Cases 8, 9: slower at first, not hindered later; with 5 % less remains than dry.", (7, 8, 9), (
        above("mean Y8 − Y7, 0.5 to 3 s", 0.0, lambda c: q.gap(c, 8, 7, 0.5, 3.0)),
        above("mean Y9 − Y7, 0.5 to 3 s", 0.0, lambda c: q.gap(c, 9, 7, 0.5, 3.0)),
        below("U8 − U7 at 20 s", 0.0, lambda c: q.undersize(c, 8, 20.0) - q.undersize(c, 7, 20.0)),
    )),
    Statement(21, "5.2, Fig. 13c", "Glass, 8 mm, 5 %: small ones for a time slower than dry near-mesh ones.", (10, 12), (
        above("largest Y_small(12) − Y_near(10)", 0.01, lambda c: q.largest(c, 12, q.SMALL, 10, q.NEAR)),
        below("Y_small(12) − Y_near(10) at 20 s", 0.01,
              lambda c: c[12].at(c[12].retained(q.SMALL), 20.0) - c[10].at(c[10].retained(q.NEAR), 20.0)),
    )),
    Statement(22, "6", "In some configurations more small moist spheres remain than dry near-mesh ones.", ONE_MM, (
        within("of 8 moist cases those with Y_small > dry Y_near + 0.01 at some time", 0.5, 7.5,
               lambda c: sum(q.largest(c, m, q.SMALL, d, q.NEAR) > 0.01 for m, d in MOIST.items() if m in ONE_MM)),
    )),
    Statement(23, "5.2, Fig. 11",
              "POM, 8 mm, 10 %, 3 s: thinner films on undersize; thin films on most walls and wires.", (3,), (
        below("film of small spheres over that of large", 1.0, lambda c: q.film(c, q.SMALL)),
        below("film of near-mesh spheres over that of large", 1.0, lambda c: q.film(c, q.NEAR)),
        above("share of wet wall triangles with thinner films than the large spheres", 0.5,
              lambda c: c[3].at(c[3].series("spheres", "thin_walls"), 3.0)),
        above("the same of wires", 0.5, lambda c: c[3].at(c[3].series("spheres", "thin_wires"), 3.0)),
    )),
    Statement(24, "5.3, Fig. 14", "At 20 s the walls hold more of the liquid with POM than with glass.", (2, 11), (
        above("share of case 2 − case 11", 0.0, lambda c: q.share(c, 2, 20.0, "walls") - q.share(c, 11, 20.0, "walls")),
    )),
    Statement(25, "5.3, Fig. 14", "At 20 s coarse glass holds a larger share than coarse POM.", (2, 11), (
        above("share of case 11 − case 2", 0.0,
              lambda c: q.share(c, 11, 20.0, q.COARSE_MATERIAL) - q.share(c, 2, 20.0, q.COARSE_MATERIAL)),
    )),
    Statement(26, "5.3, Fig. 15a",
              "Case 2: the apparatus holds nearly as much as the coarse material at 20 s, and gets closer.", (2,), (
        within("walls over coarse at 20 s", 0.75, 1.25,
               lambda c: q.share(c, 2, 20.0, "walls") / q.share(c, 2, 20.0, q.COARSE_MATERIAL)),
        below("distance at 20 s over that at 15 s", 1.0, lambda c: q.apart(c, 20.0) / q.apart(c, 15.0)),
    )),
    Statement(27, "5.3, Fig. 15",
              "At first all liquid is on the coarse material; that falls all the time, walls' and fines' rise.", (2, 8, 11, 17), (
        above("least share of the spheres on the screen at the first output", 0.999,
              lambda c: min(c[k].liquid(q.COARSE_MATERIAL)[0] for k in (2, 8, 11, 17))),
        below("largest rise of the coarse material's share between outputs", 0.005,
              lambda c: max(q.rise(c[k], q.COARSE_MATERIAL) for k in (2, 8, 11, 17))),
        below("largest fall of the fines' share between outputs", 0.005,
              lambda c: max(q.rise(c[k], "fines", -1.0) for k in (2, 8, 11, 17))),
        above("least rise of the walls' share from 0 to 20 s", 0.0,
              lambda c: min(q.share(c, k, 20.0, "walls") - q.share(c, k, 0.0, "walls") for k in (2, 8, 11, 17))),
    )),
    Statement(28, "5.3, Fig. 15", "Glass nearly reaches an equilibrium when the majority has passed; POM does not.",
              (2, 8, 11, 17), (
        below("change of a share after the majority has passed over that before, case 11", 0.1, lambda c: q.settled(c, 11)),
        below("the same, case 17", 0.1, lambda c: q.settled(c, 17)),
        above("the same, case 2 − case 11", 0.0, lambda c: q.settled(c, 2) - q.settled(c, 11)),
        above("the same, case 8 − case 17", 0.0, lambda c: q.settled(c, 8) - q.settled(c, 17)),
    )),
    Statement(29, "5.3, Fig. 15c",
              "Case 11: at first liquid rises on near-mesh and above all on large spheres, falls on small.", (11,), (
        above("largest rise on near-mesh in the first 5 s", 0.01, lambda c: q.peak(c, q.NEAR)),
        above("that on large − that on near-mesh", 0.0, lambda c: q.peak(c, COARSE) - q.peak(c, q.NEAR)),
        below("change on small when near-mesh hold most", -0.01, q.small_at_peak),
    )),
    Statement(30, "5.3, Fig. 15c",
              "Case 11: slightly more water leaves with small than near-mesh spheres, more with each near-mesh one.", (11,), (
        within("small over near-mesh through the outlet", 1.0, 1.2,
               lambda c: q.carried(c[11], q.SMALL) / q.carried(c[11], q.NEAR)),
        above("per sphere, near-mesh over small", 1.0, lambda c: q.per_sphere(c[11], q.NEAR) / q.per_sphere(c[11], q.SMALL)),
    )),
    Statement(31, "5.3, Fig. 15a, c",
              "Cases 2 and 11: at the end more liquid on the fines than on the coarse material.", (2, 11), (
        above("fines − coarse, case 2", 0.0, lambda c: q.share(c, 2, 20.0, "fines") - q.share(c, 2, 20.0, q.COARSE_MATERIAL)),
        above("fines − coarse, case 11", 0.0,
              lambda c: q.share(c, 11, 20.0, "fines") - q.share(c, 11, 20.0, q.COARSE_MATERIAL)),
    )),
    Statement(32, "5.3, Fig. 15b, d",
              "5.6 mm: small spheres are still there at 20 s; the coarse material holds more than the fines.", (8, 17), (
        above("fewest small spheres on the screen", 0.5,
              lambda c: min(c[k].at(c[k].count("above", q.SMALL), 20.0) for k in (8, 17))),
        above("least coarse − fines", 0.0,
              lambda c: min(q.share(c, k, 20.0, q.COARSE_MATERIAL) - q.share(c, k, 20.0, "fines") for k in (8, 17))),
    )),
    Statement(33, "5.3, Fig. 7",
              "Below V* = 0.4 the larger glass sphere gets relatively more than the larger POM sphere.", (), (
        above("mean share of the larger, 15° − 40°", 0.0, lambda c: larger_gets(15.0) - larger_gets(40.0)),
    )),
    Statement(34, "5.2, Fig. 12a", "POM, 8 mm, 1 mm: the influence of the water is comparatively low.", (1, 2, 3), (
        within("larger mean Y2 − Y1, Y3 − Y1, 2 to 20 s", 0.0, 0.05,
               lambda c: max(q.gap(c, k, 1, 2.0, 20.0) for k in (2, 3))),
    )),
    Statement(35, "5.2, Fig. 13c, d", "Glass: small before near-mesh with either screen at every liquid amount.",
              (10, 11, 12, 16, 17, 18), (
        below("largest mean Y_small − Y_near of these cases, 1 to 20 s", 0.0,
              lambda c: max(q.lag(c[k], 1.0, 20.0) for k in (10, 11, 12, 16, 17, 18))),
    )),
    Statement(36, "5.3, Fig. 15b, d", "5.6 mm: the liquid on the walls rises more with POM than with glass.", (8, 17), (
        above("share of case 8 − case 17 at 20 s", 0.0, lambda c: q.share(c, 8, 20.0, "walls") - q.share(c, 17, 20.0, "walls")),
    )),
    Statement(37, "5.3, Fig. 15", "The liquid of the fines rises more than that of the walls.", (2, 8, 11, 17), (
        above("least fines − walls at 20 s", 0.0,
              lambda c: min(q.share(c, k, 20.0, "fines") - q.share(c, k, 20.0, "walls") for k in (2, 8, 11, 17))),
    )),
    Statement(38, "5.3, Fig. 15a", "Case 2: nearly all undersize has passed at 20 s.", (2,), (
        below("U at 20 s", 0.02, lambda c: q.undersize(c, 2, 20.0)),
    )),
    Statement(39, "5.3, Fig. 7c, d", "Of a bridge the wall takes more from a POM sphere than from a glass sphere.", (), (
        above("mean share of a steel wall, 40° − 15°", 0.0, lambda c: wall_gets(40.0) - wall_gets(15.0)),
    )),
    *LAW_STATEMENTS,
)
# fmt: on
