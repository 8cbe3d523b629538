// CornerEstimator.measure of detection/corners.py, EdgeRefiner.refine and .bow of detection/edge_refiner.py, one marker
// after the other. Names and formulas are those of these files.
#include <cstring>
#include <vector>

#include "algebra.h"
#include "edge_fit.h"
#include "image.h"
#include "steps.h"

namespace {

using namespace alvar;

constexpr int kAlong = 22, kAcross = 13, kSides = 4, kPlaces = kSides * kAlong, kParameters = 15;
const double kNormals[kSides][2] = {{0, -1}, {1, 0}, {0, 1}, {-1, 0}};

// The order of edge_refiner.py's limits
struct Limits {
    double reach, blurs, max_reach, start, min_step, min_contrast, fits, outlier, min_outlier, min_noise, min_seen;
    double bow_reach, bow_over_noise, bow_of_one;
};

// The order of corners.py's limits
struct CornerLimits {
    double samples_per_cell, min_side, max_move, model_error, aligned_error, misfit_error, coarse_error, noise_factor;
    double cell_reach, max_cell_reach, cell_steps, min_seen, cell_variance;
};

double along(int i) { return -0.9 + 1.8 * i / (kAlong - 1); }  // edge_refiner.ALONG

double side_of(const double* quad) { return std::sqrt(area(quad)); }

// How far [cells] edges lie outside the points of the sides, and whether there is one (0 or 1)
struct Offsets {
    double offset[kPlaces], enough[kPlaces];
};

void measure_offsets(const Image& grey, const Lens& lens, const double* h, double half, const double* across,
                                const Limits& limit, Offsets& out) {
    float step[kPlaces], rest[kPlaces], sorted[kPlaces];
    for (int side = 0; side < kSides; ++side) {
        const double *n = kNormals[side], reach = across[side];
        for (int i = 0; i < kAlong; ++i) {
            const double t = along(i) * half, x = half * n[0] - t * n[1], y = half * n[1] + t * n[0];
            float u[kAcross], v[kAcross], read[kAcross], sum = 0;
            const float px = h[0] * x + h[1] * y + h[2], py = h[3] * x + h[4] * y + h[5];
            const float pw = h[6] * x + h[7] * y + h[8];
            const float ox = (h[0] * n[0] + h[1] * n[1]) * reach, oy = (h[3] * n[0] + h[4] * n[1]) * reach;
            const float ow = (h[6] * n[0] + h[7] * n[1]) * reach;
            for (int k = 0; k < kAcross; ++k) {
                const float at = (k - kAcross / 2) / float(kAcross / 2), w = 1 / (pw + at * ow);
                u[k] = (px + at * ox) * w, v[k] = (py + at * oy) * w;
            }
            lens.to_real(u, v, kAcross);
            grey.read(u, v, kAcross, read);
            for (const float each : read) sum += each;
            const float black = (read[0] + read[1] + read[2]) / 3;
            const float white = (read[kAcross - 3] + read[kAcross - 2] + read[kAcross - 1]) / 3;
            step[side * kAlong + i] = white - black, rest[side * kAlong + i] = sum / kAcross - black;
        }
    }
    std::copy(step, step + kPlaces, sorted);
    const double least = limit.min_step * std::max<double>(nth(sorted, kPlaces, kPlaces / 2), limit.min_contrast);
    for (int i = 0; i < kPlaces; ++i) {
        const bool enough = step[i] > least;
        const double share = rest[i] / (enough ? step[i] : 1.0f);
        out.enough[i] = enough;
        out.offset[i] = across[i / kAlong] * (1 - 2 * share) * kAcross / (kAcross - 1);
    }
}

// Robust lines through the offsets: offset and slope of each side, their covariance; whether all sides are visible.
bool lines_of(const Offsets& seen, double half, const double* px, const Limits& limit, double (*lines)[2],
              double (*spread)[4]) {
    double weight[kPlaces], residual[kPlaces], sorted[kPlaces], sums[kSides][3], det[kSides], noise = 0;
    std::copy(seen.enough, seen.enough + kPlaces, weight);
    for (int again = 0; again < limit.fits; ++again) {
        for (int side = 0; side < kSides; ++side) {
            double s0 = 0, s1 = 0, s2 = 0, y0 = 0, y1 = 0;
            for (int i = 0; i < kAlong; ++i) {
                const double t = along(i) * half, w = weight[side * kAlong + i], y = w * seen.offset[side * kAlong + i];
                s0 += w, s1 += w * t, s2 += w * t * t, y0 += y, y1 += y * t;
            }
            det[side] = std::max(s0 * s2 - s1 * s1, 1e-9);
            sums[side][0] = s0, sums[side][1] = s1, sums[side][2] = s2;
            lines[side][0] = (y0 * s2 - y1 * s1) / det[side], lines[side][1] = (s0 * y1 - s1 * y0) / det[side];
            for (int i = side * kAlong; i < (side + 1) * kAlong; ++i) {
                const double t = along(i % kAlong) * half;
                residual[i] = std::fabs(seen.offset[i] - lines[side][0] - lines[side][1] * t) * px[side];
            }
        }
        std::copy(residual, residual + kPlaces, sorted);
        noise = std::max(1.4826 * nth(sorted, kPlaces, kPlaces / 2), limit.min_noise);
        const double scale = 1 / std::max(limit.outlier * noise, limit.min_outlier);
        for (int i = 0; i < kPlaces; ++i) {
            const double part = residual[i] * scale, left = std::max(1 - part * part, 0.0);
            weight[i] = seen.enough[i] * left * left;
        }
    }
    bool visible = true;
    for (int side = 0; side < kSides; ++side) {
        int counted = 0;
        for (int i = 0; i < kAlong; ++i) counted += weight[side * kAlong + i] > 0.2;
        visible = visible && counted > limit.min_seen * kAlong;
        const double scale = noise * noise / (px[side] * px[side] * det[side]);
        spread[side][0] = sums[side][2] * scale, spread[side][3] = sums[side][0] * scale;
        spread[side][1] = spread[side][2] = -sums[side][1] * scale;
    }
    return visible;
}

// Corners (4, 2) [ideal px] where the edges are, and their covariance (8, 8); whether all sides are visible.
bool measure_edges(const Image& grey, const Lens& lens, const double* h, double half, const double* across,
                   const double* px, const Limits& limit, double* corners, double* covariance) {
    Offsets seen;
    double lines[kSides][2], spread[kSides][4];
    measure_offsets(grey, lens, h, half, across, limit, seen);
    const bool visible = lines_of(seen, half, px, limit, lines, spread);
    double jacobian[8][8] = {};
    for (int k = 0; k < kSides; ++k) {
        const double x = kSquare[k][0] * half, y = kSquare[k][1] * half, w = h[6] * x + h[7] * y + h[8];
        const double u = (h[0] * x + h[1] * y + h[2]) / w, v = (h[3] * x + h[4] * y + h[5]) / w;
        const double to_px[4] = {(h[0] - u * h[6]) / w, (h[1] - u * h[7]) / w, (h[3] - v * h[6]) / w,
                                 (h[4] - v * h[7]) / w};
        double moved_x = x, moved_y = y;
        for (int before = 0; before < 2; ++before) {
            const int side = (k + 4 - before) % 4;
            const double end = before ? half : -half, *n = kNormals[side];
            const double shift = lines[side][0] + lines[side][1] * end;
            moved_x += n[0] * shift, moved_y += n[1] * shift;
            for (int power = 0; power < 2; ++power) {
                const double scale = power ? end : 1;
                jacobian[2 * k][2 * side + power] += (to_px[0] * n[0] + to_px[1] * n[1]) * scale;
                jacobian[2 * k + 1][2 * side + power] += (to_px[2] * n[0] + to_px[3] * n[1]) * scale;
            }
        }
        const double moved_w = h[6] * moved_x + h[7] * moved_y + h[8];
        corners[2 * k] = (h[0] * moved_x + h[1] * moved_y + h[2]) / moved_w;
        corners[2 * k + 1] = (h[3] * moved_x + h[4] * moved_y + h[5]) / moved_w;
    }
    double half_way[8][8];  // jacobian times the block diagonal matrix of the spreads
    for (int i = 0; i < 8; ++i)
        for (int side = 0; side < kSides; ++side)
            for (int q = 0; q < 2; ++q)
                half_way[i][2 * side + q] = jacobian[i][2 * side] * spread[side][q] + jacobian[i][2 * side + 1] * spread[side][2 + q];
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) {
            double sum = 0;
            for (int k = 0; k < 8; ++k) sum += half_way[i][k] * jacobian[j][k];
            covariance[8 * i + j] = sum;
        }
    return visible;
}

// EdgeRefiner.refine
bool refine(const Image& grey, const Lens& lens, const double* h, double half, double sigma, const Limits& limit,
            double* corners, double* covariance) {
    double start[8], length[kSides], px[kSides], across[kSides], first[kSides], again[9];
    corners_at(h, half, start);
    for (int k = 0; k < kSides; ++k) {
        const int next = (k + 1) % kSides;
        length[k] = std::hypot(start[2 * next] - start[2 * k], start[2 * next + 1] - start[2 * k + 1]);
    }
    bool narrow = false, good = true;
    for (int k = 0; k < kSides; ++k) {
        px[k] = (length[(k + 1) % kSides] + length[(k + 3) % kSides]) / (4 * half);
        across[k] = std::min((limit.reach + limit.blurs * sigma) / px[k], limit.max_reach);
        first[k] = std::max(across[k], limit.start);
        narrow = narrow || across[k] < limit.start;
    }
    if (narrow) {
        good = measure_edges(grey, lens, h, half, first, px, limit, corners, covariance);
        from_square(corners, half, again);
        h = again;
    }
    return measure_edges(grey, lens, h, half, across, px, limit, corners, covariance) && good;
}

// The covariance (8, 8) of corners by that of small changes of h, the upper left part of a matrix with `wide` columns
void spread_of(const double* h, double half, const double* changes, int wide, double* spread) {
    double jacobian[8][8], part[8][8];
    for (int k = 0; k < kSides; ++k) {
        const double x = kSquare[k][0] * half, y = kSquare[k][1] * half, w = h[6] * x + h[7] * y + h[8];
        for (int axis = 0; axis < 2; ++axis) {
            const double* row = h + 3 * axis;
            const double at = (row[0] * x + row[1] * y + row[2]) / w;
            const double a = (row[0] - at * h[6]) / w, b = (row[1] - at * h[7]) / w, c = (row[2] - at * h[8]) / w;
            const double by[8] = {a, a * x, a * y, b, b * x, b * y, -c * x, -c * y};
            std::copy(by, by + 8, jacobian[2 * k + axis]);
        }
    }
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) {
            part[i][j] = 0;
            for (int k = 0; k < 8; ++k) part[i][j] += jacobian[i][k] * changes[k * wide + j];
        }
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) {
            double sum = 0;
            for (int k = 0; k < 8; ++k) sum += part[i][k] * jacobian[j][k];
            spread[8 * i + j] = sum;
        }
}

// The covariance (8, 8) [px^2] of aligned corners for noise 1
bool aligned_spread(const double* h, double half, const double* normal, double* spread) {
    double ridged[kParameters * kParameters], inverse[kParameters * kParameters];
    std::memcpy(ridged, normal, sizeof ridged);
    for (int k = 0; k < kParameters; ++k) {
        double& diagonal = ridged[k * (kParameters + 1)];
        diagonal = diagonal * (1 + 1e-6) + 1e-9;
    }
    if (!invert(ridged, inverse, kParameters)) return false;
    spread_of(h, half, inverse, kParameters, spread);
    return true;
}

// The weighted mean of aligned corners and of those of the edges; their covariance without its floor.
bool combine(const double* sharp, const double* of_edges, double* corners, double* covariance) {
    double sum[64], inverse[64], share[64], moved[8], gain[8], part[64];
    for (int i = 0; i < 64; ++i) sum[i] = covariance[i] + of_edges[i];
    if (!invert(sum, inverse, 8)) return false;
    multiply(covariance, inverse, share, 8, 8, 8);
    for (int i = 0; i < 8; ++i) moved[i] = sharp[i] - corners[i];
    multiply(share, moved, gain, 8, 8, 1);
    multiply(share, covariance, part, 8, 8, 8);
    for (int i = 0; i < 8; ++i) corners[i] += gain[i];
    for (int i = 0; i < 64; ++i) covariance[i] -= part[i];
    return true;
}

// edge_alignment.edge_points of black cells (cells, cells) at edge_alignment.PLACES
struct CellEdges {
    std::vector<double> x, y, right, down;

    CellEdges(const std::uint8_t* black, int cells) {
        const auto is_white = [&](int row, int column) {
            return row < 0 || column < 0 || row >= cells || column >= cells || !black[row * cells + column];
        };
        for (int line = 0; line < cells; ++line)
            for (int edge = 0; edge <= cells; ++edge)
                for (int axis = 0; axis < 2; ++axis) {
                    const bool before = axis ? is_white(edge - 1, line) : is_white(line, edge - 1);
                    const bool after = axis ? is_white(edge, line) : is_white(line, edge);
                    if (before == after) continue;
                    for (const double place : {-0.25, 0.25}) {
                        const double along = line + 0.5 - 0.5 * cells + place, across = edge - 0.5 * cells;
                        x.push_back(axis ? along : across), y.push_back(axis ? across : along);
                        right.push_back(axis ? 0 : after - before), down.push_back(axis ? after - before : 0);
                    }
                }
    }

    EdgePoints points() const { return {int(x.size()), x.data(), y.data(), right.data(), down.data()}; }
};

// Corners (4, 2) by the edges of all cells, and their covariance (8, 8); false if too few are seen.
bool measure_cells(const Image& grey, const Lens& lens, const double* start, double half, const EdgePoints& points,
                   const double* scale, const EdgeLimits& edges, const CornerLimits& limit, double* corners,
                   double* covariance) {
    double h[9], theta[8], changes[64], numbers[2];
    std::vector<std::uint8_t> agrees(points.count);
    from_square(start, half, h);
    const double reach = std::min(limit.cell_reach * side_of(start) / (2 * half), limit.max_cell_reach);
    if (!fit_edges(grey, lens, h, points, scale, reach, reach, limit.cell_steps, edges, theta, changes, numbers,
                   agrees.data()))
        return false;
    int seen = 0;
    for (const auto each : agrees) seen += each;
    change(h, theta);
    corners_at(h, half, corners);
    spread_of(h, half, changes, 8, covariance);
    for (int i = 0; i < 64; ++i) covariance[i] *= limit.cell_variance;
    return seen > limit.min_seen * points.count;
}

bool near(const double* a, const double* b, double reach) {
    bool all = true;
    for (int i = 0; i < 8; ++i) all = all && std::fabs(a[i] - b[i]) < reach;
    return all;
}

}  // namespace

// Changes corners (markers, 4, 2) [ideal px] of markers at h; writes their information (markers, 8, 8). `normal`
// (markers, 15, 15): that of the alignment; `kept` (markers,): share of the samples that agree;
// `black` (markers, cells, cells). Where a matrix is singular, the information is 0.
extern "C" void alvar_measure_corners(const std::uint8_t* greys, std::int64_t stride, int width, int height,
                                      const double* lens_numbers, int markers, int cells, const double* h,
                                      const double* blur, const std::int64_t* level, const double* noise,
                                      const double* kept, const double* normal, const std::uint8_t* black,
                                      const double* scale, const double* edge_limits, const double* cell_limits, const double* limits, double* corners,
                                      double* information) {
    const Image grey = {greys, stride, width, height};
    const Lens lens(lens_numbers);
    Limits of_edges;
    EdgeLimits of_cells;
    CornerLimits limit;
    std::memcpy(&of_cells, cell_limits, sizeof of_cells);
    std::memcpy(&of_edges, edge_limits, sizeof of_edges);
    std::memcpy(&limit, limits, sizeof limit);
    const double half = 0.5 * cells;
    for (int m = 0; m < markers; ++m, h += 9, corners += 8, information += 64, normal += kParameters * kParameters) {
        const double side = side_of(corners), size = std::pow(2.0, level[m]);
        double covariance[64], sharp[8], sharp_covariance[64];
        std::fill(information, information + 64, 0.0);
        if (!aligned_spread(h, half, normal, covariance)) continue;
        const double variance = limit.noise_factor * std::max(noise[m], 1.0) * std::max(noise[m], 1.0);
        const double sampled = side / cells / limit.samples_per_cell;
        const double misfit = std::max(limit.aligned_error, limit.misfit_error * (1 - kept[m]));
        const double floor = std::max(misfit * size, limit.coarse_error * sampled * sampled);
        for (double& each : covariance) each *= variance;
        for (int i = 0; i < 8; ++i) covariance[9 * i] += floor * floor;
        if (side > limit.min_side) {
            const double reach = limit.max_move * side / cells;
            const CellEdges of_marker(black + m * cells * cells, cells);
            bool moved = refine(grey, lens, h, half, std::sqrt(blur[m]) * size, of_edges, sharp, sharp_covariance)
                         && near(sharp, corners, reach) && combine(sharp, sharp_covariance, corners, covariance);
            moved |= measure_cells(grey, lens, corners, half, of_marker.points(), scale, of_cells, limit, sharp, sharp_covariance)
                     && near(sharp, corners, reach) && combine(sharp, sharp_covariance, corners, covariance);
            for (int i = 0; moved && i < 8; ++i) covariance[9 * i] += limit.model_error * limit.model_error;
        }
        if (!invert(covariance, information, 8)) std::fill(information, information + 64, 0.0);
    }
}

// Writes the bows (markers,) [px] of markers with corners (markers, 4, 2) [ideal px].
extern "C" void alvar_bows(const std::uint8_t* greys, std::int64_t stride, int width, int height,
                           const double* lens_numbers, int markers, int cells, const double* corners,
                           const double* limits, double* bows) {
    const Image grey = {greys, stride, width, height};
    const Lens lens(lens_numbers);
    Limits limit;
    std::memcpy(&limit, limits, sizeof limit);
    const double half = 0.5 * cells;
    double mean = 0;
    for (int i = 0; i < kAlong; ++i) mean += along(i) * along(i) / kAlong;
    for (int m = 0; m < markers; ++m, corners += 8) {
        double h[9], basis[3][kAlong], residual[kPlaces], height[kSides], error[kSides], sizes[kSides];
        from_square(corners, half, h);
        const double px = side_of(corners) / cells, reach = std::min(limit.bow_reach / px, limit.max_reach);
        const double across[kSides] = {reach, reach, reach, reach};
        Offsets seen;
        measure_offsets(grey, lens, h, half, across, limit, seen);
        for (int i = 0; i < kAlong; ++i) basis[0][i] = 1, basis[1][i] = along(i), basis[2][i] = along(i) * along(i) - mean;
        for (int side = 0; side < kSides; ++side) {
            const double *enough = seen.enough + side * kAlong, *offset = seen.offset + side * kAlong;
            double share[3], square[3];
            for (int k = 0; k < 3; ++k) {
                share[k] = square[k] = 0;
                for (int i = 0; i < kAlong; ++i) {
                    share[k] += enough[i] * offset[i] * basis[k][i];
                    square[k] += enough[i] * basis[k][i] * basis[k][i];
                }
                square[k] = std::max(square[k], 1e-9), share[k] /= square[k];
            }
            for (int i = 0; i < kAlong; ++i)
                residual[side * kAlong + i] = enough[i] * std::fabs(offset[i] - share[0] - share[1] * basis[1][i] - share[2] * basis[2][i]);
            height[side] = std::fabs(share[2]), error[side] = 1 / std::sqrt(square[2]);
        }
        const double noise = 1.4826 * nth(residual, kPlaces, kPlaces / 2);
        for (int k = 0; k < kSides; ++k) sizes[k] = height[k] > limit.bow_over_noise * noise * error[k] ? height[k] * px : 0;
        std::sort(sizes, sizes + kSides);
        bows[m] = std::max(sizes[2], limit.bow_of_one * sizes[3]);
    }
}

// homography.from_square of quads (count, 4, 2)
extern "C" void alvar_from_squares(int count, const double* quads, double half, double* homographies) {
    for (int i = 0; i < count; ++i) from_square(quads + 8 * i, half, homographies + 9 * i);
}
