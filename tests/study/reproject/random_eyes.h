#pragma once
/// Random eyes in the head box of one frame of a scene: the options that name them, and the views they are made of.
#include <equistream/bound.h>
#include <programs/cli/program.h>
#include <scenes/library/scene.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

namespace equistream {

struct RandomEyeOptions {
    std::string scene, sphere = "1920x960", size = "640x360";
    std::int64_t frame = 0;
    int eyes = 64;
    double head_radius_m = -1;  ///< below zero: the scene's
    std::uint64_t seed = 1;
};

inline void add_random_eye_options(cli::CommandLine& app, RandomEyeOptions& options) {
    app.add_option("SCENE", options.scene, "Scene description whose geometry is the truth").required();
    app.add_option("--frame", options.frame, "Of the scene's path").with_default();
    app.add_option("--sphere-size", options.sphere, "Of the source").with_default();
    app.add_option("--size", options.size, "Of an eye, 90 degrees wide").with_default();
    app.add_option("--eyes", options.eyes, "How many").between(1, 100000).with_default();
    app.add_option("--lean", options.head_radius_m, "Head box in metres instead of the scene's");
    app.add_option("--seed", options.seed, "Of the eyes").with_default();
}

/// Uniform in the ball, turned uniformly.
inline Pose random_eye(const glm::dvec3& centre_m, double radius_m, std::mt19937_64& generator) {
    std::uniform_real_distribution<double> side(-1, 1);
    std::normal_distribution<double> normal;
    glm::dvec3 place;
    do
        place = {side(generator), side(generator), side(generator)};
    while (glm::length(place) > 1);
    glm::dquat turned;
    turned.w = normal(generator);
    turned.x = normal(generator);
    turned.y = normal(generator);
    turned.z = normal(generator);
    return {centre_m + radius_m * place, glm::normalize(turned)};
}

/// The sphere and its eyes; whoever wants the same eyes again starts with another generator of the same seed.
struct RandomEyes {
    RandomEyes(const RandomEyeOptions& options, const SceneDescription& scene)
        : time_s(double(options.frame) / scene.frames_per_second), centre{scene.camera_path.at(time_s).position_m,
                                                                          {1, 0, 0, 0}},
          box_radius_m(head_box_radius_centre(options.head_radius_m < 0 ? scene.head_radius_m : options.head_radius_m,
                                              default_ipd_m)),
          count(options.eyes), seed(options.seed) {
        const cli::Size whole = cli::parse_size(options.sphere), part = cli::parse_size(options.size);
        sphere = {whole.width, whole.height, {}};
        eye = {part.width, part.height, pi / 2};
    }

    Pose next(std::mt19937_64& generator) const { return random_eye(centre.position_m, box_radius_m, generator); }
    std::mt19937_64 generator() const { return std::mt19937_64(seed); }

    double time_s = 0;
    Pose centre;  ///< of the sphere, its axes the world's
    double box_radius_m = 0;
    int count = 0;
    std::uint64_t seed = 1;
    EquirectCamera sphere;
    PerspectiveCamera eye;
};

inline std::vector<std::string> between_commas(const std::string& list) {
    std::vector<std::string> parts;
    for (std::size_t start = 0; start <= list.size();) {
        const std::size_t comma = std::min(list.find(',', start), list.size());
        parts.push_back(list.substr(start, comma - start));
        start = comma + 1;
    }
    return parts;
}

}  // namespace equistream
