// corners.CornerEstimator
#include <cstring>

#include "algebra.h"
#include "steps.h"

namespace {

using namespace alvar;

constexpr int kAlong = 22, kAcross = 13, kSides = 4, kPlaces = kSides * kAlong;
const double kNormals[kSides][2] = {{0, -1}, {1, 0}, {0, 1}, {-1, 0}};

// Positions along a side, as shares of its half; without the blurred corners
double along(int i) { return -0.9 + 1.8 * i / (kAlong - 1); }

double side_of(const double* quad) { return std::sqrt(area(quad)); }

// How far [cells] edges lie outside the points of the sides, and whether there is one (0 or 1)
struct Offsets {
    double offset[kPlaces], enough[kPlaces];
};

void measure_offsets(const Image& grey, const Lens& lens, const double* h, double half, const double* across,
                     const Thresholds& limit, Offsets& out) {
    float step[kPlaces], rest[kPlaces], seen[kPlaces], sorted[kPlaces];
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
            seen[side * kAlong + i] = grey.grey_of(white) - grey.grey_of(black);
        }
    }
    std::copy(seen, seen + kPlaces, sorted);
    const double least = limit.MIN_EDGE_STEP
                         * std::max<double>(nth(sorted, kPlaces, kPlaces / 2), limit.MIN_EDGE_CONTRAST);
    for (int i = 0; i < kPlaces; ++i) {
        const bool enough = seen[i] > least;
        const double share = rest[i] / (enough ? step[i] : 1.0f);
        out.enough[i] = enough;
        out.offset[i] = across[i / kAlong] * (1 - 2 * share) * kAcross / (kAcross - 1);
    }
}

// Robust lines through the offsets: offset and slope of each side, their covariance; whether all sides are visible.
bool lines_of(const Offsets& seen, double half, const double* px, const Thresholds& limit, double (*lines)[2],
              double (*spread)[4]) {
    double weight[kPlaces], residual[kPlaces], sorted[kPlaces], sums[kSides][3], det[kSides], noise = 0;
    std::copy(seen.enough, seen.enough + kPlaces, weight);
    for (int again = 0; again < limit.EDGE_FITS; ++again) {
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
        noise = std::max(1.4826 * nth(sorted, kPlaces, kPlaces / 2), limit.MIN_EDGE_NOISE);
        const double scale = 1 / std::max(limit.EDGE_OUTLIER * noise, limit.MIN_EDGE_OUTLIER);
        for (int i = 0; i < kPlaces; ++i) {
            const double part = residual[i] * scale, left = std::max(1 - part * part, 0.0);
            weight[i] = seen.enough[i] * left * left;
        }
    }
    bool visible = true;
    for (int side = 0; side < kSides; ++side) {
        int counted = 0;
        for (int i = 0; i < kAlong; ++i) counted += weight[side * kAlong + i] > 0.2;
        visible = visible && counted > limit.MIN_EDGE_SEEN * kAlong;
        const double scale = noise * noise / (px[side] * px[side] * det[side]);
        spread[side][0] = sums[side][2] * scale, spread[side][3] = sums[side][0] * scale;
        spread[side][1] = spread[side][2] = -sums[side][1] * scale;
    }
    return visible;
}

// Corners (4, 2) [ideal px] where the edges are, and their covariance (8, 8); whether all sides are visible.
bool measure_edges(const Image& grey, const Lens& lens, const double* h, double half, const double* across,
                   const double* px, const Thresholds& limit, double* corners, double* covariance) {
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
                half_way[i][2 * side + q] = jacobian[i][2 * side] * spread[side][q]
                                            + jacobian[i][2 * side + 1] * spread[side][2 + q];
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) {
            double sum = 0;
            for (int k = 0; k < 8; ++k) sum += half_way[i][k] * jacobian[j][k];
            covariance[8 * i + j] = sum;
        }
    return visible;
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

// Corners (4, 2) by the edges of all cells, and their covariance (8, 8); false if too few are seen.
bool measure_cells(const Image& grey, const Lens& lens, const double* start, int cells, const std::uint8_t* black,
                   const double* scale, const Thresholds& limit, const Light* asked, double* corners,
                   double* covariance, ResponseEvidence* evidence) {
    const double half = 0.5 * cells;
    const EdgePoints points = edge_points(black, cells, {-0.25, 0.25});  // edge_alignment.PLACES
    double h[9];
    from_square(start, half, h);
    const double reach = std::min(limit.LOCAL_REACH * side_of(start) / (2 * half), limit.MAX_LOCAL_REACH);
    const EdgeFit fit = fit_edges(grey, lens, h, points, scale, reach, reach, limit.CELL_STEPS, limit, asked,
                                  evidence);
    if (!fit.seen_enough) return false;
    int seen = 0;
    for (const auto each : fit.agrees) seen += each;
    change(h, fit.parameters);
    corners_at(h, half, corners);
    spread_of(h, half, fit.covariance, 8, covariance);
    for (int i = 0; i < 64; ++i) covariance[i] *= limit.CELL_VARIANCE;
    return seen > limit.MIN_SEEN_EDGES * fit.agrees.size();
}

bool near(const double* a, const double* b, double reach) {
    bool all = true;
    for (int i = 0; i < 8; ++i) all = all && std::fabs(a[i] - b[i]) < reach;
    return all;
}

// An aligned marker, aligned once more in light if the image has a table of it; sets the corners (4, 2) of that.
struct InLight {
    std::vector<double> numbers, normal;
    std::vector<float> samples;
    AlignedMarker marker;

    InLight(const Pyramid& pyramid, const Lens& lens, const Aligner& aligner, const AlignedMarker& aligned,
            const Thresholds& limit, double* corners)
        : marker(aligned) {
        if (!pyramid.atlas.light) return;
        const int count = aligner.count * aligner.count;
        double black = 0;
        for (int i = 0; i < count; ++i) black += aligned.dark[i] / count;
        const double contrast = *aligned.contrast;
        const auto at = [&](double grey) {
            return pyramid.atlas.light[std::min(std::max(int(std::lround(grey)), 0), kGreys - 1)];
        };
        // the contrast keeps its size: thresholds and noise are greys
        const double scale = contrast / std::max<double>(at(black + contrast) - at(black), 1e-3);
        float light[kGreys];
        for (int i = 0; i < kGreys; ++i) light[i] = scale * pyramid.atlas.light[i];
        numbers.assign(aligned.h, aligned.h + 9);
        numbers.resize(13), numbers[9] = *aligned.blur;
        normal.resize(kParameters * kParameters), samples.resize(std::size_t(6) * count);
        float* first = samples.data();
        double* own = numbers.data();
        std::vector<AlignedMarker> one = {{own, own + 9, aligned.level, aligned.black, first, first + count,
                                           first + 2 * count, first + 3 * count, first + 4 * count, first + 5 * count,
                                           own + 10, own + 11, own + 12, normal.data()}};
        const Pyramid lit = {pyramid.atlas.lit(light), pyramid.levels};
        aligner.run(lit, lens, one, int(limit.LIGHT_STEPS), 0, limit);
        double moved[8];
        corners_at(own, 0.5 * aligner.cells, moved);
        if (!near(moved, corners, limit.MAX_EDGE_MOVE * side_of(corners) / aligner.cells)) return;
        marker = one[0];
        std::copy(moved, moved + 8, corners);
    }
    InLight(const InLight&) = delete;
};

}  // namespace

bool alvar::refine_edges(const Image& grey, const Lens& lens, const double* h, double half, double sigma,
                         const Thresholds& limit, double* corners, double* covariance) {
    double start[8], length[kSides], px[kSides], across[kSides], first[kSides], again[9];
    corners_at(h, half, start);
    for (int k = 0; k < kSides; ++k) {
        const int next = (k + 1) % kSides;
        length[k] = std::hypot(start[2 * next] - start[2 * k], start[2 * next + 1] - start[2 * k + 1]);
    }
    bool narrow = false, good = true;
    for (int k = 0; k < kSides; ++k) {
        px[k] = (length[(k + 1) % kSides] + length[(k + 3) % kSides]) / (4 * half);
        across[k] = std::min((limit.EDGE_REACH + limit.EDGE_BLURS * sigma) / px[k], limit.MAX_EDGE_REACH);
        first[k] = std::max(across[k], limit.EDGE_START);
        narrow = narrow || across[k] < limit.EDGE_START;
    }
    if (narrow) {
        good = measure_edges(grey, lens, h, half, first, px, limit, corners, covariance);
        from_square(corners, half, again);
        h = again;
    }
    return measure_edges(grey, lens, h, half, across, px, limit, corners, covariance) && good;
}

void alvar::measure_corners(const Measured& image, const Lens& lens, const Aligner& aligner,
                            const AlignedMarker& aligned, double inlier_share, const double* scale,
                            const Thresholds& limit, double* corners, double* information, ResponseEvidence* evidence) {
    const InLight in_light(image.pyramid, lens, aligner, aligned, limit, corners);
    const AlignedMarker& marker = in_light.marker;
    const int cells = aligner.cells;
    const double half = 0.5 * cells, side = side_of(corners), size = std::pow(2.0, marker.level);
    double covariance[64], sharp[8], sharp_covariance[64];
    std::fill(information, information + 64, 0.0);
    if (!aligned_spread(marker.h, half, marker.normal, covariance)) return;
    const double noise = std::max(*marker.noise, 1.0), variance = limit.CORNER_NOISE_FACTOR * noise * noise;
    const double sampled = side / cells / limit.SAMPLES_PER_CELL;
    const double misfit = std::max(limit.ALIGNED_ERROR, limit.MISFIT_ERROR * (1 - inlier_share));
    const double floor = std::max(misfit * size, limit.COARSE_CORNER_ERROR * sampled * sampled);
    for (double& each : covariance) each *= variance;
    for (int i = 0; i < 8; ++i) covariance[9 * i] += floor * floor;
    if (side > limit.MIN_EDGE_SIDE) {
        const double reach = limit.MAX_EDGE_MOVE * side / cells, sigma = std::sqrt(*marker.blur) * size;
        bool moved = refine_edges(image.full, lens, marker.h, half, sigma, limit, sharp, sharp_covariance)
                     && near(sharp, corners, reach) && combine(sharp, sharp_covariance, corners, covariance);
        ResponseEvidence seen = {};
        const bool agree = measure_cells(image.full, lens, corners, cells, marker.black, scale, limit, image.asked,
                                         sharp, sharp_covariance, &seen)
                           && near(sharp, corners, reach);
        if (agree && evidence) *evidence = seen;
        moved |= agree && combine(sharp, sharp_covariance, corners, covariance);
        for (int i = 0; moved && i < 8; ++i)
            covariance[9 * i] += limit.CORNER_MODEL_ERROR * limit.CORNER_MODEL_ERROR;
    }
    if (!invert(covariance, information, 8)) std::fill(information, information + 64, 0.0);
}

double alvar::bow(const Image& grey, const Lens& lens, const double* corners, int cells, const Thresholds& limit) {
    const double half = 0.5 * cells;
    double mean = 0;
    for (int i = 0; i < kAlong; ++i) mean += along(i) * along(i) / kAlong;
    double h[9], basis[3][kAlong], residual[kPlaces], height[kSides], error[kSides], sizes[kSides];
    from_square(corners, half, h);
    const double px = side_of(corners) / cells, reach = std::min(limit.BOW_REACH / px, limit.MAX_EDGE_REACH);
    const double across[kSides] = {reach, reach, reach, reach};
    Offsets seen;
    measure_offsets(grey, lens, h, half, across, limit, seen);
    for (int i = 0; i < kAlong; ++i) {
        basis[0][i] = 1, basis[1][i] = along(i), basis[2][i] = along(i) * along(i) - mean;  // at right angles
    }
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
            residual[side * kAlong + i] = enough[i] * std::fabs(offset[i] - share[0] - share[1] * basis[1][i]
                                                                - share[2] * basis[2][i]);
        height[side] = std::fabs(share[2]), error[side] = 1 / std::sqrt(square[2]);
    }
    const double noise = 1.4826 * nth(residual, kPlaces, kPlaces / 2);
    for (int k = 0; k < kSides; ++k)
        sizes[k] = height[k] > limit.BOW_OVER_NOISE * noise * error[k] ? height[k] * px : 0;
    std::sort(sizes, sizes + kSides);
    return std::max(sizes[2], limit.BOW_OF_ONE * sizes[3]);
}
