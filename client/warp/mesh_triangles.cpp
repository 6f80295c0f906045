#include "mesh.h"

#include <algorithm>
#include <limits>

namespace equistream {

namespace {

/// Beyond this many pixels to any side triangles are clipped first, before coordinates lose their digits.
constexpr float farthest_px = 32768;

LatticePoint middle(const LatticePoint& a, const LatticePoint& b) {
    return {(a.q + b.q) * 0.5f, 0.5f * (a.k + b.k)};
}

class TriangleMaker {
public:
    TriangleMaker(const SeenBlock& seen, const MeshCells& cells, const NeighbourCells& neighbours, BlockTriangles& out)
        : block_(seen.block), joined_(seen.joined), cells_(cells), neighbours_(neighbours),
          projection_(seen.projection), both_sides_(seen.both_sides), out_(out) {
        index_.fill(none);
    }

    void run() {
        for (const MeshCell& cell : cells_.cells) {
            // Cells over a pole are turned over: which way round they come says nothing.
            either_way_ = both_sides_ || block_.y0 + cell.y < 0;
            if (!cell.whole)
                add_cut(cell.x, cell.y);
            else
                add_whole(cell);
        }
        out_.top = std::numeric_limits<float>::infinity();
        out_.bottom = -out_.top;
        for (const auto& triangle : out_.triangles)
            for (const std::uint32_t i : triangle) {
                out_.top = std::min(out_.top, out_.vertices[i].y);
                out_.bottom = std::max(out_.bottom, out_.vertices[i].y);
            }
    }

private:
    struct Corner {
        LatticePoint point;
        int vertex = none;
    };
    static constexpr int none = -1;

    bool is_corner(int x, int y) const {
        if (cells_.is_corner(x, y))
            return true;
        return (x == 0 && neighbours_.left && neighbours_.left->is_corner(neighbours_.left_columns, y)) ||
               (x == block_.columns && neighbours_.right && neighbours_.right->is_corner(0, y)) ||
               (y == 0 && neighbours_.above && neighbours_.above->is_corner(x, LatticeBlock::side)) ||
               (y == block_.rows && neighbours_.below && neighbours_.below->is_corner(x, 0));
    }

    int add_vertex(const LatticePoint& p) {
        const EyePoint seen = projection_.project(p);
        const bool good = seen.before && std::abs(seen.x) < farthest_px && std::abs(seen.y) < farthest_px;
        if (!good)
            return none;
        out_.vertices.push_back({seen.x, seen.y, std::max(seen.inverse_planar, 0.0f)});
        return int(out_.vertices.size()) - 1;
    }
    Corner corner(int x, int y) {
        int& known = index_[LatticeBlock::at(x, y)];
        const LatticePoint p = block_.point(x, y);
        if (known == none)
            known = add_vertex(p);
        return {p, known};
    }
    Corner corner(const LatticePoint& p) { return {p, add_vertex(p)}; }

    void add_whole(const MeshCell& cell) {
        const int x = cell.x, y = cell.y, size = cell.side;
        const Corner a = corner(x, y), d = corner(x + size, y + size);
        border_.clear();
        for (int i = 0; i < size; ++i)
            add_to_border(x + i, y);
        for (int i = 0; i < size; ++i)
            add_to_border(x + size, y + i);
        for (int i = size; i > 0; --i)
            add_to_border(x + i, y + size);
        for (int i = size; i > 0; --i)
            add_to_border(x, y + i);
        if (size == 1 || border_.size() <= 4) {
            add(a, corner(x + size, y), d);
            add(a, d, corner(x, y + size));
            return;
        }
        const Corner centre = corner(x + size / 2, y + size / 2);
        for (std::size_t i = 0; i < border_.size(); ++i)
            add(centre, border_[i], border_[(i + 1) % border_.size()]);
    }
    void add_to_border(int x, int y) {
        if (is_corner(x, y))
            border_.push_back(corner(x, y));
    }

    /// Each corner has the quarter of the cell next to it; what is joined meets in common points, what is not goes on
    /// along its own plane up to the middle and ends there.
    void add_cut(int x, int y) {
        struct Place {
            int x, y;
        };
        const std::array<Place, 4> places{{{x, y}, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}}};
        // Whether corner i is joined to the next one, clockwise.
        const int first = LatticeBlock::at(x, y);
        const std::array<bool, 4> joined{joined_.right[first] != 0, joined_.down[first + 1] != 0,
                                         joined_.right[first + LatticeBlock::stride] != 0, joined_.down[first] != 0};
        std::array<float, 4> at_centre{};
        std::array<int, 4> part{0, 1, 2, 3};
        for (int i = 0; i < 4; ++i)
            if (joined[i]) {
                const int from = part[(i + 1) % 4], to = part[i];
                std::ranges::replace(part, from, to);
            }
        for (int i = 0; i < 4; ++i) {
            const Place p = places[i];
            const float dx = p.x == x ? 0.5f : -0.5f, dy = p.y == y ? 0.5f : -0.5f;
            at_centre[i] = continued(p.x, p.y, dx, dy);
        }
        glm::vec3 direction(0);
        for (const Place& p : places)
            direction = direction + block_.point(p.x, p.y).q * 0.25f;
        for (int i = 0; i < 4; ++i) {
            const Corner here = corner(places[i].x, places[i].y);
            if (!(here.point.k >= 0))
                continue;
            float sum = 0;
            int count = 0;
            for (int j = 0; j < 4; ++j)
                if (part[j] == part[i]) {
                    sum += at_centre[j];
                    ++count;
                }
            const Corner centre = corner(LatticePoint{direction, std::max(sum / float(count), 0.0f)});
            const Corner next =
                towards(places[i].x, places[i].y, places[(i + 1) % 4].x, places[(i + 1) % 4].y, joined[i]);
            const Corner last =
                towards(places[i].x, places[i].y, places[(i + 3) % 4].x, places[(i + 3) % 4].y, joined[(i + 3) % 4]);
            add(here, next, centre);
            add(here, centre, last);
        }
    }

    /// Halfway from one lattice point to the next.
    Corner towards(int x, int y, int to_x, int to_y, bool joined) {
        LatticePoint half = middle(block_.point(x, y), block_.point(to_x, to_y));
        if (!joined)
            half.k = std::max(continued(x, y, 0.5f * float(to_x - x), 0.5f * float(to_y - y)), 0.0f);
        return corner(half);
    }

    /// The inverse distance that a point's own surface has a little beside it.
    float continued(int x, int y, float dx, float dy) const {
        const int i = LatticeBlock::at(x, y);
        const auto slope = [&](const std::uint8_t* joined, int step, float towards) {
            const bool before = joined[i - step] != 0, after = joined[i] != 0;
            if (after && (towards > 0 || !before))
                return block_.k[i + step] - block_.k[i];
            return before ? block_.k[i] - block_.k[i - step] : 0;
        };
        return block_.k[i] + dx * slope(joined_.right.data(), 1, dx) +
               dy * slope(joined_.down.data(), LatticeBlock::stride, dy);
    }

    void add(const Corner& a, const Corner& b, const Corner& c) {
        if (a.vertex != none && b.vertex != none && c.vertex != none)
            add_indices(a.vertex, b.vertex, c.vertex);
        else
            add_clipped(a.point, b.point, c.point);
    }
    void add_indices(int a, int b, int c) {
        const float area = twice_area(out_.vertices[a], out_.vertices[b], out_.vertices[c]);
        if (area > 0)
            out_.triangles.push_back({std::uint32_t(a), std::uint32_t(b), std::uint32_t(c)});
        else if (area < 0 && either_way_)
            out_.triangles.push_back({std::uint32_t(a), std::uint32_t(c), std::uint32_t(b)});
    }

    struct Homogeneous {
        glm::vec3 h;
        float k;
    };
    /// Against the four sides of the view, a pixel wider: what is inside all of them is before the eye.
    void add_clipped(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
        std::vector<Homogeneous> polygon, rest;
        for (const LatticePoint& p : {a, b, c}) {
            if (!(p.k >= 0))
                return;
            polygon.push_back({projection_.homogeneous(p), p.k});
        }
        const float width = float(projection_.width()), height = float(projection_.height());
        for (int plane = 0; plane < 4; ++plane) {
            const auto inside = [&](const Homogeneous& p) {
                return plane == 0   ? p.h.x + p.h.z
                       : plane == 1 ? width * p.h.z - p.h.x
                       : plane == 2 ? p.h.y + p.h.z
                                    : height * p.h.z - p.h.y;
            };
            rest.clear();
            for (std::size_t i = 0; i < polygon.size(); ++i) {
                const Homogeneous &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
                const float at_p = inside(p), at_q = inside(q);
                if (at_p >= 0)
                    rest.push_back(p);
                if ((at_p >= 0) != (at_q >= 0)) {
                    const float t = at_p / (at_p - at_q);
                    rest.push_back({p.h * (1 - t) + q.h * t, p.k * (1 - t) + q.k * t});
                }
            }
            polygon.swap(rest);
        }
        const int first = int(out_.vertices.size());
        for (const Homogeneous& p : polygon) {
            const float scale = 1 / std::max(p.h.z, 1e-12f);
            out_.vertices.push_back({p.h.x * scale, p.h.y * scale, p.k * scale});
        }
        for (int i = 2; i < int(polygon.size()); ++i)
            add_indices(first, first + i - 1, first + i);
    }

    const LatticeBlock& block_;
    const JoinedPoints& joined_;
    const MeshCells& cells_;
    const NeighbourCells& neighbours_;
    const EyeProjection& projection_;
    bool both_sides_;
    BlockTriangles& out_;
    bool either_way_ = false;
    std::array<int, LatticeBlock::stride * LatticeBlock::stride> index_{};
    std::vector<Corner> border_;
};

}  // namespace

void make_triangles(const SeenBlock& seen, const MeshCells& cells, const NeighbourCells& neighbours,
                    BlockTriangles& out) {
    out.vertices.clear();
    out.triangles.clear();
    TriangleMaker(seen, cells, neighbours, out).run();
}

}  // namespace equistream
