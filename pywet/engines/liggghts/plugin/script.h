// What a script of the user's own can print: of each sphere film [m3] and number of bridges; of all together, in this order, liquid
// put in, on spheres, in bridges, on walls, gone with spheres [m3], bridges, formations, ruptures, their capillary energy [J].
#pragma once
#include <vector>

namespace pywet {

const int ALL = 9, OF_SPHERE = 5;       // its bridges' force is in the last three

void tell_spheres(double **rows, int n);
void tell_all(double (&sums)[ALL]);     // every rank takes part

// What the engine's restart file holds of the liquid besides the films on spheres: every rank takes part, the first one knows.
std::vector<double> state_of_script();

}  // namespace pywet
