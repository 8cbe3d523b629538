// prepared_image.noise_of, and the levels of pyramid.Pyramid in light
#include <algorithm>
#include <cmath>

#include "steps.h"

double alvar::noise_of(const Image& grey) {
    std::vector<std::int64_t> counts(4 * 255 + 1, 0);
    std::int64_t all = 0;
    for (int y = 4; y < grey.height; y += std::max(1, grey.height / 12)) {
        const std::uint8_t* row = grey.greys + y * grey.stride;
        for (int x = 1; x < grey.width - 1; ++x) ++counts[std::abs(2 * row[x] - row[x - 1] - row[x + 1])];
        all += std::max(0, grey.width - 2);
    }
    std::int64_t before = 0;
    std::size_t k = 0;
    while (k + 1 < counts.size() && 2 * (before + counts[k]) < all) before += counts[k++];
    const double middle = k ? k - 0.5 + (0.5 * all - before) / std::max<std::int64_t>(counts[k], 1) : 0.5;
    return middle / (0.6745 * std::sqrt(6.0));
}

void alvar::halve(const Image& grey, const Light& light, std::uint8_t* out, std::int64_t stride) {
    int steps[kGreys];
    for (int i = 0; i < kGreys; ++i) steps[i] = std::lround(light.of_grey[i] * ((Light::kSteps - 1.0) / (kGreys - 1)));
    for (int y = 0; y < grey.height / 2; ++y) {
        const std::uint8_t *upper = grey.greys + 2 * y * grey.stride, *lower = upper + grey.stride;
        std::uint8_t* row = out + y * stride;
        for (int x = 0; x < grey.width / 2; ++x) {
            const int left = steps[upper[2 * x]] + steps[lower[2 * x]];
            const int right = steps[upper[2 * x + 1]] + steps[lower[2 * x + 1]];
            row[x] = light.grey_at[(left + right) / 4];
        }
    }
}
