// The steps of the detector, as detector.cpp and Python call them; each .cpp file says what it writes.
#pragma once
#include <cstdint>

extern "C" {

int alvar_refine_sides(const std::uint8_t* greys, std::int64_t stride, int width, int height, const double* limits,
                       int count, double* quads);

int alvar_match_coarse(const std::uint8_t* greys, std::int64_t stride, int width, int height, int count,
                       const double* quads, const double* limits, const float* rim, int cells, const float* cell_points,
                       int all_words, const float* words, std::int64_t* kept, double* homographies, double* fits,
                       std::int64_t* best);

double alvar_coarse_fit(const std::uint8_t* greys, std::int64_t stride, int width, int height, const double* quad,
                        double half, double spread, int cells, const float* cell_points, int all_words,
                        const float* words);

void alvar_align(int markers, const std::uint8_t* atlas, std::int64_t stride, int width, int height, const float* table,
                 const double* lens_numbers, int cells, int count, const float* line, const float* weight,
                 const float* normal_step, const double* limits, int steps, unsigned redraw, const std::uint8_t* black,
                 const std::int64_t* level, double* h, double* blur, float* samples, double* numbers, double* normal);

void alvar_features(int markers, int samples, const float* values, const float* drawing, const float* model,
                    const float* gain, const float* weights, const float* share, double all_weight, const double* noise,
                    int data_count, const std::int64_t* data, const float* smooth, int cells, const std::int32_t* group,
                    const std::uint8_t* is_data, double max_noise_share, double bad_cell, double* out);

void alvar_read(int markers, int side, const float* values, const float* line, int resolution, const float* light,
                const float* normal_step, const double* variance, const double* noise, int all_words,
                const float* words, double max_noise_share, double* out, std::int64_t* best);

void alvar_measure_corners(const std::uint8_t* greys, std::int64_t stride, int width, int height,
                           const double* lens_numbers, int markers, int cells, const double* h, const double* blur,
                           const std::int64_t* level, const double* noise, const double* kept,
                           const double* normal, const std::uint8_t* black, const double* scale,
                           const double* edge_limits, const double* cell_limits, const double* limits, double* corners,
                           double* information);

void alvar_poses(int markers, const double* corners, const double* sizes, const double* lens_numbers,
                 const double* information, double* rows, int* found);

}
