#include "find_moving_regions.h"

#include "fit_twist.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

namespace equistream {
namespace {

/// Points that a fit is made of, of larger pieces evenly taken.
constexpr std::size_t fitted_points = 1500;
/// Share of a piece's pixels that its twist must move within the error: outlines hold some of other surfaces.
constexpr double fitted_share = 0.98;
/// Share of a piece's pixels that each neighbour must show: a few fit any twist.
constexpr double shown_share = 0.5;
/// A piece is not halved below this; a twist that leaves this share of its movement is better than none.
constexpr std::size_t min_halved = 64;
constexpr double useful_share = 0.5;
/// Neighbouring pixels belong together where their movements differ by no more than this share.
constexpr double same_movement_share = 0.25;

struct Pixel {
    int x = 0, y = 0;
};

/// What one pixel shows of one neighbour.
struct Observation {
    SeenPoint point;
    glm::dvec3 moved{0, 0, 0};  ///< across the ray, radians: what the camera's movement does not explain
    bool known = false;
};

class Search {
public:
    Search(const MotionPlanes& planes, const MotionSearch& search)
        : planes_(planes), search_(search), width_(planes.depth_m.width), height_(planes.depth_m.height),
          moves_(std::size_t(width_) * std::size_t(height_)), region_(moves_.size(), none) {
        tbb::parallel_for(0, height_, [&](int y) {
            for (int x = 0; x < width_; ++x)
                for (const MotionNeighbour& neighbour : planes_.neighbours)
                    if (glm::length(at({x, y}, neighbour).moved) > tolerance_rad(neighbour))
                        moves_[index_of({x, y})] = 1;
        });
    }

    FoundMotion find() {
        for (std::vector<Pixel>& piece : pieces())
            fit(std::move(piece));
        return result();
    }

private:
    static constexpr int none = -1;

    struct Fitted {
        std::vector<RigidTransform> movements;  ///< to each neighbour
        std::int64_t pixels = 0;
        float near_m = INFINITY, far_m = 0;
    };

    std::size_t index_of(Pixel p) const { return std::size_t(p.y) * std::size_t(width_) + std::size_t(p.x); }
    int& region_of(Pixel p) { return region_[index_of(p)]; }
    bool moves(Pixel p) const { return moves_[index_of(p)] != 0; }

    glm::dvec3 offset_m(const MotionNeighbour& neighbour) const {
        return neighbour.pose.position_m - planes_.pose.position_m;
    }
    /// As much of the error as of the horizon passes until then.
    double tolerance_rad(const MotionNeighbour& neighbour) const {
        return search_.error_rad * std::abs(neighbour.seconds) / search_.horizon_s;
    }

    /// Made again for the few that are asked for again: kept, they would be 80 bytes a pixel.
    Observation at(Pixel p, const MotionNeighbour& neighbour) const {
        Observation o;
        const float depth_m = *planes_.depth_m.pixel(p.x, p.y);
        const float* motion = neighbour.motion_px.pixel(p.x, p.y);
        // Beyond the picture's size is what lies behind a flat view.
        if (!(depth_m > 0 && std::isfinite(depth_m) && std::abs(motion[0]) <= float(width_) &&
              std::abs(motion[1]) <= float(height_)))
            return o;
        o.known = true;
        const double u = p.x + 0.5, v = p.y + 0.5;
        o.point.at_m = double(depth_m) * (planes_.pose.orientation * direction_of(planes_.camera, u, v));
        o.point.seen = neighbour.pose.orientation * direction_of(planes_.camera, u + motion[0], v + motion[1]);
        o.moved = o.point.seen - glm::normalize(o.point.at_m - offset_m(neighbour));
        return o;
    }

    std::vector<std::vector<Pixel>> pieces() {
        return planes_.object_id.data != nullptr ? objects() : connected_pieces();
    }

    /// All pixels of each object of which some move: those that hardly do are on its axis.
    std::vector<std::vector<Pixel>> objects() {
        std::map<std::uint32_t, std::vector<Pixel>> by_id;
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x)
                if (moves({x, y}))
                    by_id[*planes_.object_id.pixel(x, y)];
        if (by_id.empty())
            return {};
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x)
                if (const auto found = by_id.find(*planes_.object_id.pixel(x, y));
                    found != by_id.end() && at({x, y}, planes_.neighbours.front()).known)
                    found->second.push_back({x, y});
        std::vector<std::vector<Pixel>> objects;
        for (auto& [id, pixels] : by_id)
            objects.push_back(std::move(pixels));
        return objects;
    }

    bool belong_together(Pixel a, Pixel b) {
        const MotionNeighbour& neighbour = planes_.neighbours.front();
        const glm::dvec3 ma = at(a, neighbour).moved, mb = at(b, neighbour).moved;
        return glm::distance(ma, mb) <=
               tolerance_rad(neighbour) + same_movement_share * std::min(glm::length(ma), glm::length(mb));
    }

    std::vector<std::vector<Pixel>> connected_pieces() {
        std::vector<std::vector<Pixel>> pieces;
        std::vector<bool> taken(moves_.size(), false);
        const auto take = [&](Pixel p) {
            if (taken[index_of(p)] || !moves(p))
                return false;
            taken[index_of(p)] = true;
            return true;
        };
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x) {
                if (!take({x, y}))
                    continue;
                std::vector<Pixel> piece{{x, y}};
                for (std::size_t i = 0; i < piece.size(); ++i) {
                    const Pixel p = piece[i];
                    for (Pixel q : {Pixel{p.x - 1, p.y}, {p.x + 1, p.y}, {p.x, p.y - 1}, {p.x, p.y + 1}}) {
                        if (columns_close(planes_.camera))
                            q.x = (q.x + width_) % width_;
                        if (q.x >= 0 && q.x < width_ && q.y >= 0 && q.y < height_ && belong_together(p, q) && take(q))
                            piece.push_back(q);
                    }
                }
                pieces.push_back(std::move(piece));
            }
        return pieces;
    }

    void fit(std::vector<Pixel> piece) {
        if (piece.size() < std::size_t(search_.min_pixels))
            return;
        Fitted fitted;
        bool fits = true;
        double left_rad = 0, moved_rad = 0;
        for (const MotionNeighbour& neighbour : planes_.neighbours) {
            const std::vector<Pixel> known = known_of(piece, neighbour);
            if (double(known.size()) < std::max(double(search_.min_pixels), shown_share * double(piece.size())))
                return;
            fitted.movements.push_back(movement_of(known, neighbour));
            std::size_t within = 0;
            for (const Pixel p : known) {
                const Observation o = at(p, neighbour);
                const double angle = angle_left_rad(o.point, fitted.movements.back(), offset_m(neighbour));
                within += angle <= tolerance_rad(neighbour);
                left_rad += angle;
                moved_rad += glm::length(o.moved);
            }
            fits = fits && double(within) >= fitted_share * double(known.size());
        }
        if (!fits && piece.size() >= min_halved)
            return halve(std::move(piece));
        const bool any_moves = std::ranges::any_of(piece, [&](Pixel p) { return moves(p); });
        if (!any_moves || (!fits && left_rad > useful_share * moved_rad))
            return;
        for (const Pixel p : piece) {
            region_of(p) = int(fitted_.size());
            const float depth_m = *planes_.depth_m.pixel(p.x, p.y);
            fitted.near_m = std::min(fitted.near_m, depth_m);
            fitted.far_m = std::max(fitted.far_m, depth_m);
        }
        fitted.pixels = std::int64_t(piece.size());
        fitted_.push_back(fitted);
    }

    std::vector<Pixel> known_of(const std::vector<Pixel>& piece, const MotionNeighbour& neighbour) const {
        std::vector<Pixel> known;
        std::ranges::copy_if(piece, std::back_inserter(known), [&](Pixel p) { return at(p, neighbour).known; });
        return known;
    }

    /// The neighbour shows all of these pixels.
    RigidTransform movement_of(const std::vector<Pixel>& piece, const MotionNeighbour& neighbour) const {
        std::vector<SeenPoint> points;
        const std::size_t stride = (piece.size() + fitted_points - 1) / fitted_points;
        for (std::size_t i = 0; i < piece.size(); i += stride)
            points.push_back(at(piece[i], neighbour).point);
        return fit_movement(points, offset_m(neighbour));
    }

    /// As the fitted twists are the mean ones on the way, they are those of half-way there.
    BodyMotion motion_of(const Fitted& fitted) const {
        std::vector<Twist> twists;
        for (std::size_t i = 0; i < fitted.movements.size(); ++i)
            twists.push_back(twist_of(fitted.movements[i], planes_.neighbours[i].seconds));
        if (twists.size() == 1)
            return {{single(twists[0].velocity_m_s), single(twists[0].angular_rad_s)}, {}};
        const double a_s = planes_.neighbours[0].seconds / 2, b_s = planes_.neighbours[1].seconds / 2;
        const auto line = [&](const glm::dvec3& a, const glm::dvec3& b) {
            const glm::dvec3 slope = (b - a) / (b_s - a_s);
            return std::pair(single(a - a_s * slope), single(slope));
        };
        const auto [velocity, velocity_slope] = line(twists[0].velocity_m_s, twists[1].velocity_m_s);
        const auto [angular, angular_slope] = line(twists[0].angular_rad_s, twists[1].angular_rad_s);
        return {{velocity, angular}, {velocity_slope, angular_slope}};
    }
    /// As it is stored, so that what is measured counts rounding.
    static glm::dvec3 single(const glm::dvec3& v) { return glm::dvec3(glm::vec3(v)); }

    /// Across its longer side.
    void halve(std::vector<Pixel> piece) {
        const auto [left, right] = std::ranges::minmax(piece, {}, &Pixel::x);
        const auto [top, bottom] = std::ranges::minmax(piece, {}, &Pixel::y);
        const auto middle = piece.begin() + std::ptrdiff_t(piece.size() / 2);
        if (right.x - left.x >= bottom.y - top.y)
            std::ranges::nth_element(piece, middle, {}, &Pixel::x);
        else
            std::ranges::nth_element(piece, middle, {}, &Pixel::y);
        fit({middle, piece.end()});
        piece.erase(middle, piece.end());
        fit(std::move(piece));
    }

    FoundMotion result() {
        std::vector<int> order(fitted_.size());
        for (std::size_t i = 0; i < order.size(); ++i)
            order[i] = int(i);
        std::ranges::stable_sort(order, std::ranges::greater(), [&](int i) { return fitted_[std::size_t(i)].pixels; });
        order.resize(std::min(order.size(), std::size_t{max_moving_regions}));
        std::vector<int> place(fitted_.size(), none);
        FoundMotion found;
        for (const int i : order) {
            const Fitted& fitted = fitted_[std::size_t(i)];
            place[std::size_t(i)] = int(found.regions.size());
            found.regions.push_back({motion_of(fitted), fitted.near_m, fitted.far_m, {}});
        }
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x) {
                int& region = region_of({x, y});
                region = region == none ? none : place[std::size_t(region)];
                if (region == none)
                    continue;
                std::vector<PixelRun>& runs = found.regions[std::size_t(region)].runs;
                if (!runs.empty() && runs.back().row == y && runs.back().end == x)
                    ++runs.back().end;
                else
                    runs.push_back({y, x, x + 1});
            }
        measure(found);
        return found;
    }

    void measure(FoundMotion& found) {
        std::vector<double> errors;
        double motion_rad = 0, error_rad = 0;
        for (const MotionNeighbour& neighbour : planes_.neighbours) {
            std::vector<RigidTransform> movements;
            for (const MovingRegion& region : found.regions)
                movements.push_back(moved_by(region.motion, neighbour.seconds));
            const double to_horizon = search_.horizon_s / std::abs(neighbour.seconds);
            for (int y = 0; y < height_; ++y)
                for (int x = 0; x < width_; ++x) {
                    if (!moves({x, y}))
                        continue;
                    const Observation o = at({x, y}, neighbour);
                    if (!o.known)
                        continue;
                    const int region = region_of({x, y});
                    const double moved = glm::length(o.moved);
                    const double left =
                        region == none ? moved
                                       : angle_left_rad(o.point, movements[std::size_t(region)], offset_m(neighbour));
                    errors.push_back(left * to_horizon);
                    motion_rad += moved * to_horizon;
                    error_rad += errors.back();
                }
        }
        found.moving_pixels = std::ranges::count(moves_, 1);
        if (errors.empty())
            return;
        found.mean_motion_rad = motion_rad / double(errors.size());
        found.mean_error_rad = error_rad / double(errors.size());
        const auto p95 = errors.begin() + std::ptrdiff_t(0.95 * double(errors.size() - 1));
        std::ranges::nth_element(errors, p95);
        found.p95_error_rad = *p95;
    }

    const MotionPlanes& planes_;
    const MotionSearch& search_;
    int width_, height_;
    std::vector<std::uint8_t> moves_;
    std::vector<int> region_;
    std::vector<Fitted> fitted_;
};

}  // namespace

FoundMotion find_moving_regions(const MotionPlanes& planes, const MotionSearch& search) {
    return Search(planes, search).find();
}

}  // namespace equistream
