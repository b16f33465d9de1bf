// Values that a user's script can print: for each sphere film [m3] and number of bridges; summed over all, in this order, liquid put in,
// on spheres, in bridges, on walls, removed with spheres [m3], bridges, formations, ruptures, their capillary energy [J].
#pragma once
#include <vector>

namespace pywet {

const int ALL = 9, OF_SPHERE = 5;       // the last three values of a sphere are the force of its bridges

void copy_sphere_values(double **rows, int n);
void copy_sums(double (&sums)[ALL]);     // collective

// Content of the engine's restart file about the liquid, without the films on spheres: collective, the result is on the first rank.
std::vector<double> state_of_script();

}  // namespace pywet
