#pragma once
/// What the plain engines are made of.
#include <client/warp/engine.h>

namespace equistream::plain {

/// `rotation` or `eye-depth`.
std::unique_ptr<Engine> make_resample_engine(bool surface, const EngineOptions& options);

/// A sample of the source, 0 to 255. Of planes as RGB in 8 bits, from the real-valued formula (yuv.h): chroma between
/// its own samples, on the even columns and between the rows, the picture's border repeated.
glm::dvec3 colour_of_sample(const SourceView& source, int x, int y);

/// What the plain ways to find an eye's depth work with.
struct PlainTask {
    const SourceView& source;
    const EyeView& eye;
    EngineOptions options;

    glm::dvec3 eye_from_source_m() const { return eye.pose.position_m - source.pose.position_m; }
    double box_radius_m() const;
    double tolerance_rad() const;
};

/// Fills 1 / planar depth of every pixel of the eye, negative where nothing is found.
void find_by_splat(const PlainTask& task, Image<double>& inverse_planar);
void find_by_mesh(const PlainTask& task, bool plain, Image<double>& inverse_planar);
void find_by_lean(const PlainTask& task, Image<double>& inverse_planar);

}  // namespace equistream::plain
