#include "hidden_layer.h"

#include <equistream/bound.h>
#include <equistream/conventions.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace equistream {
namespace {

es_ray ray_of(const es_tile& tile, std::uint32_t pixel, const FrameRays& rays) {
    const auto width = static_cast<std::uint32_t>(tile.width);
    es_ray ray = rays.geometry(tile.x + static_cast<int>(pixel % width), tile.y + static_cast<int>(pixel / width));
    ray.pixel = pixel;
    return ray;
}

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Opposite ones follow each other: an edge that hides a surface from one side seldom hides it from the other.
constexpr int rim_eyes = 8, inner_eyes = 4;
constexpr std::array<int, rim_eyes> rim_order = {0, 4, 2, 6, 1, 5, 3, 7};

double budget() {
    return std::sin(error_budget_rad(default_focal_length_px));
}
/// Of the budget: what tells surfaces apart that are none of the first.
double share() {
    return default_budget_share * budget();
}

double distance_of(double w, double box_radius_m) {
    return w > 0 ? box_radius_m + box_radius_m / w : infinity;
}

glm::dvec3 vector_of(const float (&v)[3]) {
    return {v[0], v[1], v[2]};
}

/// So many turns round a direction.
glm::dvec3 across(const glm::dvec3& direction, double turns) {
    const glm::dvec3 helper = std::abs(direction.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 right = glm::normalize(glm::cross(direction, helper)), up = glm::cross(right, direction);
    return std::cos(2 * pi * turns) * right + std::sin(2 * pi * turns) * up;
}

}  // namespace

HiddenLayer::Search& HiddenLayer::search_of(const es_tile& tile) {
    const std::lock_guard lock(mutex_);
    Search& search = searches_[tile.id];
    if (search.pixels.empty())
        search.pixels.resize(tile.pixel_count);
    return search;
}

const HiddenLayer::Found* HiddenLayer::found(const es_tile& tile) const {
    const std::lock_guard lock(mutex_);
    const auto known = found_.find(tile.id);
    return known == found_.end() ? nullptr : &known->second;
}

std::uint32_t HiddenLayer::ask(const es_tile& tile, const FrameRays& rays, es_ray* out) {
    if (found(tile) != nullptr)
        return 0;
    Search& search = search_of(tile);
    search.asked.clear();
    for (std::uint32_t pixel = 0; pixel < tile.pixel_count; ++pixel)
        if (!search.pixels[pixel].is_done()) {
            *out++ = search.pixels[pixel].question(ray_of(tile, pixel, rays), box_);
            search.asked.push_back(pixel);
        }
    const auto count = static_cast<std::uint32_t>(search.asked.size());
    if (count == 0)
        finish(tile, search);
    return count;
}

bool HiddenLayer::tell(const es_tile& tile, const FrameRays& rays, const float* distances_m) {
    if (found(tile) != nullptr)
        return false;
    Search& search = search_of(tile);
    if (search.asked.empty())
        return false;
    for (const std::uint32_t pixel : search.asked)
        search.pixels[pixel].answer(*distances_m++, ray_of(tile, pixel, rays), box_);
    search.asked.clear();
    return true;
}

void HiddenLayer::finish(const es_tile& tile, const Search& search) {
    Found found;
    for (std::uint32_t pixel = 0; pixel < tile.pixel_count; ++pixel)
        if (const float begin_m = search.pixels[pixel].begin_m(); !std::isnan(begin_m)) {
            found.pixels.push_back(pixel);
            found.begin_m.push_back(begin_m);
        }
    const std::lock_guard lock(mutex_);
    searches_.erase(tile.id);  // `search` is gone from here on
    found_[tile.id] = std::move(found);
}

float HiddenSearch::begin_m() const {
    return step_ == Step::found ? front_m_ : std::numeric_limits<float>::quiet_NaN();
}

/// From the box's centre, across the ray.
glm::dvec3 HiddenSearch::eye_offset_m(const es_ray& ray, const HeadBox& box) const {
    const glm::dvec3 d = vector_of(ray.direction);
    if (eye_ >= rim_eyes)
        return 0.5 * box.radius_m * across(d, (eye_ - rim_eyes + 0.5) / inner_eyes);
    const double turned_per_m = 1 / double{first_m_} - 1 / double{behind_m_};
    const double wider_m = 0.5 * double{ray.footprint_rad} / turned_per_m;
    const double rim_m = std::min(2 * box.radius_m, box.radius_m / std::cos(pi / rim_eyes) + wider_m);
    return rim_m * across(d, rim_order[eye_] / static_cast<double>(rim_eyes));
}

double HiddenSearch::distance_from_eye_m(const es_ray& ray, const HeadBox& box) const {
    if (std::isinf(behind_m_))
        return infinity;
    return glm::length(double{behind_m_} * vector_of(ray.direction) - eye_offset_m(ray, box));
}

es_ray HiddenSearch::question(const es_ray& pixel_ray, const HeadBox& box) const {
    es_ray ray = pixel_ray;
    if (step_ == Step::behind)
        ray.t_min = behind_m_;
    if (step_ != Step::seen)
        return ray;
    const glm::dvec3 d = vector_of(pixel_ray.direction), aside = eye_offset_m(pixel_ray, box);
    const glm::dvec3 eye = box.centre_m + aside;
    const glm::dvec3 towards = std::isinf(behind_m_) ? d : glm::normalize(double{behind_m_} * d - aside);
    for (int axis = 0; axis < 3; ++axis) {
        ray.origin[axis] = static_cast<float>(eye[axis]);
        ray.direction[axis] = static_cast<float>(towards[axis]);
    }
    return ray;
}

/// Beyond what is `step_w` or less behind the last surface.
void HiddenSearch::look_behind(double step_w, const HeadBox& box) {
    const double w = bounded_inverse_depth(front_m_, box.radius_m) - step_w;
    step_ = w > 0 && surfaces_ < max_surfaces_behind ? Step::behind : Step::none;
    // A surface inside the box has no bound: what is not, comes after it.
    behind_m_ = static_cast<float>(std::isinf(w) ? box.radius_m : distance_of(w, box.radius_m));
}

void HiddenSearch::answer(float distance_m, const es_ray& pixel_ray, const HeadBox& box) {
    const float met_m = distance_m >= 0 ? distance_m : std::numeric_limits<float>::infinity();
    if (step_ == Step::first) {
        first_m_ = front_m_ = met_m;
        look_behind(budget(), box);
        return;
    }
    if (step_ == Step::behind) {
        behind_m_ = std::max(met_m, behind_m_);
        ++surfaces_;
        eye_ = 0;
        step_ = Step::seen;
        return;
    }
    const double there = bounded_inverse_depth(distance_from_eye_m(pixel_ray, box), box.radius_m);
    const double met = bounded_inverse_depth(met_m, box.radius_m);
    const double w_front = bounded_inverse_depth(front_m_, box.radius_m);
    const double w_behind = bounded_inverse_depth(behind_m_, box.radius_m);
    if (met <= there + share() && std::isfinite(met)) {
        front_m_ = std::isinf(w_front) ? static_cast<float>(box.radius_m)
                                       : static_cast<float>(distance_of(0.5 * (w_front + w_behind), box.radius_m));
        step_ = Step::found;
    } else if (++eye_ == rim_eyes + inner_eyes) {
        front_m_ = behind_m_;
        look_behind(share(), box);
    }
}

}  // namespace equistream
