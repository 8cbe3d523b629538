// LocalDecoder.contrasts of detection/local_contrast.py.
#include "image.h"

namespace {

using namespace alvar;

ALVAR_FAST void read(const Image& smooth, const float* h, const float* points, int count, int stride, float* grey) {
    float u[kBlock], v[kBlock];
    for (int i = 0; i < count; ++i) {
        const float x = points[i], y = points[stride + i], w = 1 / (h[6] * x + h[7] * y + h[8]);
        u[i] = (h[0] * x + h[1] * y + h[2]) * w, v[i] = (h[3] * x + h[4] * y + h[5]) * w;
    }
    smooth.read(u, v, count, grey);
}

}  // namespace

// out (markers, pairs) of points (3, 2 * pairs): first those before the edges, then those after them.
extern "C" void alvar_contrasts(const std::uint8_t* greys, std::int64_t stride, int width, int height, int markers,
                                const float* h, int pairs, const float* points, float dark_grey, float* out) {
    const Image smooth = {greys, stride, width, height};
    float before[kBlock], after[kBlock];
    for (int m = 0; m < markers; ++m)
        for (int first = 0; first < pairs; first += kBlock) {
            const int count = pairs - first < kBlock ? pairs - first : kBlock;
            read(smooth, h + 9 * m, points + first, count, 2 * pairs, before);
            read(smooth, h + 9 * m, points + pairs + first, count, 2 * pairs, after);
            for (int i = 0; i < count; ++i)
                out[m * pairs + first + i] = (after[i] - before[i]) / (after[i] + before[i] + dark_grey);
        }
}
