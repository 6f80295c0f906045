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
void find_on_proxy_sphere(const PlainTask& task, Image<double>& inverse_planar);

// A source's depth as a surface, in double precision: the definition that the fast lattice is held to.

/// (q, k) stands for the point q / k, from the source's position in its own axes.
struct PlainPoint {
    glm::dvec3 q{0};
    double k = 0;
};

/// Where a point falls in the eye: continuous pixel coordinates and 1 / planar depth. NaN behind it.
struct PlainEyePoint {
    glm::dvec2 pixel{0};
    double inverse_planar = 0;
};

class PlainSurface {
public:
    explicit PlainSurface(const PlainTask& task);

    int width() const { return width_; }
    int height() const { return height_; }
    bool closes() const { return closes_; }
    /// 1 / distance of a sample, once round a sphere or over its poles; NaN beyond the picture.
    double inverse(int x, int y) const;
    /// Of a sample, of one round or over, or just beyond the picture.
    glm::dvec3 direction(int x, int y) const;
    PlainPoint point(int x, int y) const { return {direction(x, y), inverse(x, y)}; }
    /// Of the picture's edge half a pixel beyond a sample (coordinates -1, W, H): led on along the last two samples.
    PlainPoint edge_point(int x, int y) const;
    bool is_sample(int x, int y) const;

    /// Whether two inverse distances are within the budget of each other for every eye of the box.
    bool same(double a, double b) const { return std::abs(w(a) - w(b)) <= tolerance_; }
    /// Whether (x, y) and (x + dx, y + dy) show one surface: one step right or down.
    bool joined(int x, int y, int dx, int dy) const;
    /// The inverse distance of a sample's own surface a little beside it.
    double continued(int x, int y, double du, double dv) const;

    PlainEyePoint project(const PlainPoint& p) const;

private:
    double w(double inverse) const;
    double edge_or_sample(int x, int y) const;

    const PlainTask& task_;
    int width_ = 0, height_ = 0;
    bool closes_ = false, north_pole_ = false, south_pole_ = false;
    double box_m_ = 0, tolerance_ = 0;
};

}  // namespace equistream::plain
