#include "plain_surface.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace equistream::plain {

namespace {

struct Axis {
    glm::dvec2 step;
    double inverse_planar = 0;
    double half = 0.55;  ///< of a step, to either side
};

/// Half of the way from neighbour to neighbour; of one neighbour where there is one; a pixel at equal distance if none.
Axis axis_of(const PlainSurface& surface, int x, int y, int dx, int dy) {
    const PlainEyePoint here = surface.project(surface.point(x, y));
    struct Step {
        glm::dvec2 pixels;
        double inverse_planar;
    };
    std::optional<Step> before, after;
    if (surface.is_sample(x - dx, y - dy) && surface.joined(x - dx, y - dy, dx, dy)) {
        const PlainEyePoint p = surface.project(surface.point(x - dx, y - dy));
        if (!std::isnan(p.inverse_planar))
            before = {here.pixel - p.pixel, here.inverse_planar - p.inverse_planar};
    }
    if (surface.is_sample(x + dx, y + dy) && surface.joined(x, y, dx, dy)) {
        const PlainEyePoint p = surface.project(surface.point(x + dx, y + dy));
        if (!std::isnan(p.inverse_planar))
            after = {p.pixel - here.pixel, p.inverse_planar - here.inverse_planar};
    }
    if (before && after) {
        Axis axis{0.5 * (before->pixels + after->pixels), 0.5 * (before->inverse_planar + after->inverse_planar)};
        const double longest = std::max(glm::length(before->pixels), glm::length(after->pixels));
        axis.half = 0.5 * longest / glm::length(axis.step) + 0.05;
        return axis;
    }
    if (before || after) {
        const Step& one = before ? *before : *after;
        return {one.pixels, one.inverse_planar};
    }
    const PlainEyePoint beside = surface.project({surface.direction(x + dx, y + dy), surface.inverse(x, y)});
    return {beside.pixel - here.pixel, beside.inverse_planar - here.inverse_planar};
}

}  // namespace

/// A buffer of depths decides what is in front, not an order.
void find_by_splat(const PlainTask& task, Image<double>& inverse_planar) {
    const PlainSurface surface(task);
    for (int y = 0; y < surface.height(); ++y)
        for (int x = 0; x < surface.width(); ++x) {
            const PlainEyePoint here = surface.project(surface.point(x, y));
            if (std::isnan(here.inverse_planar))
                continue;
            Axis across = axis_of(surface, x, y, 1, 0);
            const Axis down = axis_of(surface, x, y, 0, 1);
            // A pixel next to a sphere's pole is wider at one edge than in its middle.
            const double width = glm::distance(surface.direction(0, y), surface.direction(1, y));
            const double wider = std::max(glm::distance(surface.direction(0, y - 1), surface.direction(1, y - 1)),
                                          glm::distance(surface.direction(0, y + 1), surface.direction(1, y + 1)));
            across.half *= 0.5 + 0.5 * wider / width;
            const glm::dmat2 steps(across.step, down.step);
            if (!(glm::determinant(steps) > 0))
                continue;
            const glm::dmat2 inverse = glm::inverse(steps);
            const glm::dvec2 half = across.half * glm::abs(across.step) + down.half * glm::abs(down.step);
            if (std::max(half.x, half.y) > 32)
                continue;
            for (int j = std::max(0, int(here.pixel.y - half.y - 1)); j <= int(here.pixel.y + half.y + 1); ++j)
                for (int i = std::max(0, int(here.pixel.x - half.x - 1)); i <= int(here.pixel.x + half.x + 1); ++i) {
                    if (i >= inverse_planar.width() || j >= inverse_planar.height())
                        continue;
                    const glm::dvec2 place = inverse * (glm::dvec2(i + 0.5, j + 0.5) - here.pixel);
                    if (std::abs(place.x) > across.half || std::abs(place.y) > down.half)
                        continue;
                    const double value =
                        here.inverse_planar + place.x * across.inverse_planar + place.y * down.inverse_planar;
                    double& nearest = *inverse_planar.pixel(i, j);
                    nearest = std::max(nearest, std::max(value, 0.0));
                }
        }
}

}  // namespace equistream::plain
