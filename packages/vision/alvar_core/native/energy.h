// Energies of greys without their noise, or without the part that some functions explain: for acceptance.cpp and
// reading.cpp
#pragma once
#include <algorithm>

namespace alvar {

constexpr int kMostFunctions = 6;

inline double without_noise(double energy, double noise, double max_share) {
    return energy - std::min(noise, max_share * energy);
}

// Removes the part of `values` (count,) that an orthonormal basis (count, functions) explains.
inline void remove_part(float* values, const float* basis, int count, int functions) {
    double shares[kMostFunctions] = {};
    for (int i = 0; i < count; ++i)
        for (int k = 0; k < functions; ++k) shares[k] += double(values[i]) * basis[i * functions + k];
    for (int i = 0; i < count; ++i) {
        double part = 0;
        for (int k = 0; k < functions; ++k) part += shares[k] * basis[i * functions + k];
        values[i] -= part;
    }
}

}  // namespace alvar
