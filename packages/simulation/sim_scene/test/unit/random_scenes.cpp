// Draws random worlds, from inside and outside of solids, through cameras of all sizes: for test_sanitized.py, which
// compiles this with the renderer and the sanitizers of g++. Images are as small as they may be: any step beside them
// is found.
#include <cstdio>
#include <memory>
#include <random>

#include "scene.h"

using namespace robotont;

namespace {

std::mt19937 generator(1);

double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(generator); }
int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(generator); }

std::vector<Solid> random_solids() {
    std::vector<Solid> solids;
    for (int k = whole(0, 12); k > 0; --k) {
        const double x = between(-2, 2), y = between(-2, 2), height = between(0.01, 2), bottom = between(-1, 0.3);
        if (whole(0, 2)) {
            solids.push_back(Solid::make_box(x, y, between(-4, 4), between(0.01, 3), between(0.01, 3),
                                             std::max(bottom, 0.0), height));
            solids.back().levels = level_sizes(whole(1, 2), between(0, 1));
            for (int face = 0; face < kRound; ++face)
                if (whole(0, 3)) solids.back().resolution[face] = between(1, 2000);
        } else
            solids.push_back(Solid::make_cylinder(x, y, between(0.01, 1), std::max(bottom, 0.0), height));
        solids.back().rank = k;
    }
    return solids;
}

// A source on the heap for each run, so that a step beyond its tones is one beyond its memory.
struct Sources {
    std::vector<std::unique_ptr<std::uint8_t[]>> tones;
    std::vector<std::unique_ptr<std::uint16_t[]>> light;
    std::vector<Source> each;
    std::vector<const Source*> of_runs;

    Sources(const Visible& visible, const std::vector<Solid>& solids) : each(visible.runs.size()) {
        for (std::size_t k = 0; k < each.size(); ++k) {
            const Run& run = visible.runs[k];
            if (run.kind == kFront && !std::isnan(solids[run.solid].resolution[run.face])) {
                each[k].width = whole(2, 40), each[k].height = whole(2, 40);
                const int size = each[k].width * each[k].height;
                tones.emplace_back(new std::uint8_t[size]), light.emplace_back(new std::uint16_t[size]);
                std::generate_n(tones.back().get(), size, [] { return whole(0, 1) * 255; });
                std::generate_n(light.back().get(), size, [] { return whole(0, 65535); });
                each[k].tones = tones.back().get(), each[k].light = light.back().get();
                each[k].tint = {65536, 256, 0}, each[k].pad = whole(0, 4);
                each[k].along = between(1, 300), each[k].up = between(1, 300), each[k].top = between(0, 3);
            }
            each[k].curved = run.face == kRound;
            of_runs.push_back(&each[k]);
        }
    }
};

Response response(double gamma) {
    std::array<std::uint16_t, Response::kValues> light;
    for (int value = 0; value < Response::kValues; ++value)
        light[value] = static_cast<std::uint16_t>(
            std::max<double>(value, std::nearbyint(Response::kFull * std::pow(value / 255.0, gamma))));
    return Response(light);
}

void draw(const Camera& camera, const std::vector<Solid>& solids, const Background& background) {
    static const Response responses[] = {response(1.0), response(2.2), response(4.0)};
    Visible visible;  // used again, as in a Scene
    for (int view = 0; view < 4; ++view) {
        const double z[] = {0.2, 1.5, 0.0, -1.0};
        const Pose pose(between(-3, 3), between(-3, 3), z[view], between(-4, 4));
        find_visible(camera, pose, solids, &visible);
        const Sources sources(visible, solids);
        std::vector<std::uint8_t> pixels(camera.width * camera.height * 3);
        std::vector<float> depths(camera.width * camera.height);
        draw_picture({camera, pose, solids, visible, sources.of_runs, background, {0.8, 0.1, 0.1}, responses[view % 3]},
                     view % 2, pixels.data());
        draw_depth(camera, pose, solids, visible, 0.4, 5.0, depths.data());
    }
}

}  // namespace

int main() {
    for (int world = 0; world < 2000; ++world) {
        const int width = whole(16, 90), height = whole(16, 70);
        const Camera camera(width, height, between(0.2, 3.0) * width, 0.5 * width, 0.5 * height, 0.02);
        std::vector<std::uint8_t> fine(257 * 257), coarse(129 * 129);
        for (std::uint8_t& tone : coarse) tone = whole(0, 1) * 255;
        const std::vector<std::uint16_t> fine_light(fine.size()), coarse_light(coarse.size(), 65535);
        const std::vector<FloorImage> floor = {{{fine.data(), fine_light.data(), 257, 257}, 8},
                                               {{coarse.data(), coarse_light.data(), 129, 129}, 7}};
        const Background background = {std::vector<Colour>(height), floor, {65536, 65536, 65536}, 1.0, 1.1};
        draw(camera, random_solids(), background);
    }
    std::puts("drawn");
}
