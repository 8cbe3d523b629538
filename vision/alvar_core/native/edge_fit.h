// The fit of a marker to the edges of its cells, for edge_alignment.cpp and corners.cpp.
#pragma once
#include "image.h"

namespace alvar {

// The order of edge_alignment.py's limits
struct EdgeLimits {
    double min_contrast, min_step, dark_grey, outlier, min_outlier, settled;
};

struct EdgePoints {  // (count,) each: places in cells, direction from black to white
    int count;
    const double *x, *y, *right, *down;
};

// EdgeAligner.fit with the model Plane, from h (3, 3) on: theta (8), covariance (8, 8), numbers: error, cost;
// agrees (count,). False if too few edges are seen.
bool fit_edges(const Image& grey, const Lens& lens, const double* h, const EdgePoints& points, const double* scale,
               double reach, double first_reach, int steps, const EdgeLimits& limit, double* theta, double* covariance,
               double* numbers, std::uint8_t* agrees);

}  // namespace alvar
