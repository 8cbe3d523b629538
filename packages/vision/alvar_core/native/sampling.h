// Greys at points of a marker, and the largest of some numbers: for reading.cpp and local_contrast.cpp
#pragma once
#include "steps.h"

namespace alvar {

// Greys at homogeneous points (3, stride), of which `count` are read from `first` on.
inline void read(const Image& smooth, const float* h, const float* points, int stride, int first, int count,
                 float* grey) {
    float u[kBlock], v[kBlock];
    for (int i = 0; i < count; i += kBlock) {
        const int some = std::min(kBlock, count - i);
        for (int k = 0; k < some; ++k) {
            const float* p = points + first + i + k;
            const float x = p[0], y = p[stride], w = 1 / (h[6] * x + h[7] * y + h[8]);
            u[k] = (h[0] * x + h[1] * y + h[2]) * w, v[k] = (h[3] * x + h[4] * y + h[5]) * w;
        }
        smooth.read(u, v, some, grey + i);
    }
}

// The index of the largest of `count` numbers; sets its difference from the next one.
inline int best_of(const float* numbers, int count, float* score_gap) {
    int best = 0;
    float second = -1e9f;
    for (int i = 1; i < count; ++i)
        if (numbers[i] > numbers[best]) second = numbers[best], best = i;
        else if (numbers[i] > second) second = numbers[i];
    *score_gap = numbers[best] - second;
    return best;
}

}  // namespace alvar
