#include "sky_openings.h"

#include <equistream/conventions.h>

#include <plugin/formulas/also_for_avx2.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace equistream::embree_host {
namespace {

/// Openings of a list are tested so many at a time.
constexpr std::size_t together = 16;

/// 1 - cosine of the angle that a ball of squared radius `radius2` fills at a squared distance; 2: all round.
float cone_of(float radius2, float distance2) {
    if (distance2 <= radius2)
        return 2;
    const float sine2 = radius2 / distance2;
    return sine2 / (1 + std::sqrt(1 - sine2));
}

}  // namespace

void OpeningList::append(std::span<const SkyOpening> openings, std::vector<float>& numbers) {
    const std::size_t padded = (openings.size() + together - 1) / together * together;
    const auto add = [&](float padding, const auto& number) {
        for (std::size_t i = 0; i < padded; ++i)
            numbers.push_back(i < openings.size() ? number(openings[i]) : padding);
    };
    for (int axis = 0; axis < 3; ++axis)
        add(0, [&](const SkyOpening& opening) { return opening.centre[axis]; });
    add(-1, [](const SkyOpening& opening) { return opening.radius2; });  // no direction meets that
    float sum = 0;
    add(1, [&](const SkyOpening& opening) { return sum += opening.share; });
    if (!openings.empty())
        numbers[numbers.size() - 1 - (padded - openings.size())] = 1;
}

glm::vec3 OpeningList::sample(const glm::vec3& from, glm::vec2 u) const {
    const float* sums = row(4);
    std::uint32_t i = 0;
    for (std::size_t k = 0; k < count_; ++k)
        i += u.x >= sums[k];
    const float before = i > 0 ? sums[i - 1] : 0;
    u.x = std::clamp((u.x - before) / (sums[i] - before), 0.0f, 0x1.fffffep-1f);
    const glm::vec3 across = glm::vec3(row(0)[i], row(1)[i], row(2)[i]) - from;
    const float distance2 = glm::dot(across, across);
    const float cone = cone_of(row(3)[i], distance2);
    if (cone == 2)
        return sample_cone(u, 2);
    return glm::normalize(ShadingFrame(across / std::sqrt(distance2)).to_world(sample_cone(u, cone)));
}

EQUISTREAM_ALSO_FOR_AVX2
float OpeningList::pdf(const glm::vec3& from, const glm::vec3& direction) const {
    const float *x = row(0), *y = row(1), *z = row(2), *radius2 = row(3), *sums = row(4);
    std::array<float, together> distance2, beyond;  // beyond: at least 0 where the direction meets the ball
    float sum = 0;
    for (std::size_t first = 0; first < count_; first += together) {
        for (std::size_t i = 0; i < together; ++i) {
            const std::size_t k = first + i;
            const float dx = x[k] - from.x, dy = y[k] - from.y, dz = z[k] - from.z;
            const float along = dx * direction.x + dy * direction.y + dz * direction.z;
            // Across the direction, not by Pythagoras: that cancels for small balls far away.
            const float cx = dy * direction.z - dz * direction.y, cy = dz * direction.x - dx * direction.z,
                        cz = dx * direction.y - dy * direction.x;
            distance2[i] = dx * dx + dy * dy + dz * dz;
            beyond[i] = radius2[k] - (along > 0 ? cx * cx + cy * cy + cz * cz : distance2[i]);
        }
        float most = -1;
        for (std::size_t i = 0; i < together; ++i)
            most = beyond[i] > most ? beyond[i] : most;
        for (std::size_t i = 0; most >= 0 && i < together; ++i)
            if (const std::size_t k = first + i; beyond[i] >= 0)
                sum += (sums[k] - (k > 0 ? sums[k - 1] : 0)) / cone_of(radius2[k], distance2[i]);
    }
    return sum / (2 * pi_f);
}

namespace {

/// A cell has at least half as many records, or all of its side. Fewer would miss openings that light it.
constexpr std::size_t records_a_cell = 16384;
constexpr std::size_t max_openings = 64;  // of a cell

/// Axis of the largest component, twice; odd where it is negative.
std::size_t facing(const glm::vec3& normal) {
    const int axis = longest_axis(glm::abs(normal));
    return 2 * static_cast<std::size_t>(axis) + (normal[axis] < 0);
}

}  // namespace

class SkyOpenings::Builder {
public:
    Builder(SkyOpenings& table, std::span<const SkyRecord> records, std::span<const SkyOpening> openings)
        : table_(table), records_(records), openings_(openings) {}

    void build() {
        place();
        std::vector<Made> made(ranges_.size());
        tbb::parallel_for(std::size_t{0}, ranges_.size(), [&](std::size_t c) { make_cell(c, made[c]); });
        double light = 0, count = 0;
        for (const Made& m : made) {
            light += m.light;
            count += m.count;
        }
        const double mean = light / std::max(count, 1.0);
        table_.gain_ = gain(made, mean);
        for (const Made& m : made) {
            const std::size_t first = table_.numbers_.size();
            OpeningList::append(m.list, table_.numbers_);
            const double skylight = m.light / std::max(m.count, 1.0) / std::max(mean, 1e-30);
            table_.cells_.push_back({static_cast<std::uint32_t>(first),
                                     static_cast<std::uint32_t>(table_.numbers_.size() - first),
                                     static_cast<float>(skylight)});
        }
    }

private:
    struct Range {
        std::size_t begin, end;
    };
    struct Made {
        std::vector<SkyOpening> list;
        double light = 0, count = 0;      // sums over the cell's records
        double unguided = 0, guided = 0;  // variance, times count
    };

    /// Of variance relative to what a cell looks like: over the square of its light and that of all cells.
    static double gain(std::span<const Made> made, double mean) {
        double unguided = 0, guided = 0;
        for (const Made& m : made)
            if (m.count > 0 && mean > 0) {
                const double level = m.light / m.count + mean;
                unguided += m.unguided / (level * level);
                guided += m.guided / (level * level);
            }
        return guided > 0 ? unguided / guided : 1;
    }

    /// Sorts the records into cells.
    void place() {
        std::array<std::vector<std::uint32_t>, 6> sides;
        for (std::uint32_t i = 0; i < records_.size(); ++i)
            if (records_[i].goes_on)
                sides[facing(unpack_direction(records_[i].normal))].push_back(i);
        for (std::size_t s = 0; s < sides.size(); ++s) {
            const std::size_t begin = order_.size();
            order_.insert(order_.end(), sides[s].begin(), sides[s].end());
            table_.roots_[s] = static_cast<std::uint32_t>(table_.nodes_.size());
            table_.nodes_.emplace_back();
            split(table_.roots_[s], {begin, order_.size()});
        }
    }

    void split(std::uint32_t node, const Range& range) {
        glm::vec3 low(INFINITY), high(-INFINITY);
        for (std::size_t i = range.begin; i < range.end; ++i) {
            low = glm::min(low, records_[order_[i]].position);
            high = glm::max(high, records_[order_[i]].position);
        }
        const std::size_t count = range.end - range.begin;
        const int axis = longest_axis(high - low);
        if (count <= records_a_cell || !(high[axis] > low[axis])) {
            table_.nodes_[node] = {0, 3, static_cast<std::uint32_t>(ranges_.size())};
            ranges_.push_back(range);
            return;
        }
        const auto first = order_.begin() + static_cast<std::ptrdiff_t>(range.begin);
        const auto middle = first + static_cast<std::ptrdiff_t>(count / 2);
        const auto lower = [&](std::uint32_t a, std::uint32_t b) {
            const float pa = records_[a].position[axis], pb = records_[b].position[axis];
            return pa < pb || (pa == pb && a < b);
        };
        std::nth_element(first, middle, order_.begin() + static_cast<std::ptrdiff_t>(range.end), lower);
        const auto child = static_cast<std::uint32_t>(table_.nodes_.size());
        table_.nodes_[node] = {records_[*middle].position[axis], static_cast<std::uint32_t>(axis), child};
        table_.nodes_.resize(child + 2);
        split(child, {range.begin, range.begin + count / 2});
        split(child + 1, {range.begin + count / 2, range.end});
    }

    static bool meets(const SkyOpening& opening, const glm::vec3& from, const glm::vec3& direction, float& distance2) {
        const glm::vec3 across = opening.centre - from;
        distance2 = glm::dot(across, across);
        const glm::vec3 aside = glm::cross(across, direction);
        return (glm::dot(across, direction) > 0 ? glm::dot(aside, aside) : distance2) <= opening.radius2;
    }

    void make_cell(std::size_t c, Made& made) const {
        const auto members = std::span(order_).subspan(ranges_[c].begin, ranges_[c].end - ranges_[c].begin);
        std::vector<std::uint32_t> lit;
        for (const std::uint32_t i : members)
            if (records_[i].light > 0)
                lit.push_back(i);
        made.count = static_cast<double>(members.size());
        double squares = 0;
        for (const std::uint32_t i : lit) {
            made.light += double{records_[i].weight} * records_[i].light;
            squares += double{records_[i].weight} * records_[i].light * records_[i].light;
        }
        if (!(made.light > 0))
            return;
        choose_openings(lit, made.list);
        const double of_mean = made.light * made.light / made.count;
        const double sampled = squares_with(made.list, lit);
        if (sampled > squares)
            made.list.clear();
        made.unguided = std::max(squares - of_mean, 0.0);
        made.guided = std::clamp(sampled - of_mean, 0.0, made.unguided);
    }

    /// The openings that send most light, with their shares. Light that several could send is shared out.
    void choose_openings(std::span<const std::uint32_t> lit, std::vector<SkyOpening>& list) const {
        std::vector<float> light(openings_.size(), 0);
        std::vector<std::uint32_t> met;
        for (const std::uint32_t i : lit) {
            const SkyRecord& r = records_[i];
            const glm::vec3 direction = glm::normalize(unpack_direction(r.direction));
            met.clear();
            float distance2 = 0;
            for (std::uint32_t k = 0; k < openings_.size(); ++k)
                if (meets(openings_[k], r.position, direction, distance2))
                    met.push_back(k);
            for (const std::uint32_t k : met)
                light[k] += r.weight * r.light / static_cast<float>(met.size());
        }
        std::vector<std::uint32_t> order;
        for (std::uint32_t k = 0; k < openings_.size(); ++k)
            if (light[k] > 0)
                order.push_back(k);
        std::ranges::sort(order,
                          [&](auto a, auto b) { return light[a] > light[b] || (light[a] == light[b] && a < b); });
        order.resize(std::min(max_openings, order.size()));
        float total = 0;
        for (const std::uint32_t k : order)
            total += light[k];
        for (const std::uint32_t k : order)
            list.push_back({openings_[k].centre, openings_[k].radius2, light[k] / total});
    }

    /// Sum of the squares of what both ways of sampling give where they are weighted by the power heuristic. Each
    /// record is judged by a list that it has no part in.
    double squares_with(std::span<const SkyOpening> list, std::span<const std::uint32_t> lit) const {
        double total = 0, sum = 0;
        for (const std::uint32_t i : lit)
            total += double{records_[i].weight} * records_[i].light;
        for (const std::uint32_t i : lit) {
            const SkyRecord& r = records_[i];
            const glm::vec3 direction = glm::normalize(unpack_direction(r.direction));
            const double own = double{r.weight} * r.light / total;
            double met = 0, density = 0;
            float distance2 = 0;
            for (const SkyOpening& opening : list)
                met += meets(opening, r.position, direction, distance2);
            for (const SkyOpening& opening : list)
                if (meets(opening, r.position, direction, distance2))
                    density += std::max(opening.share - own / met, 0.0) / cone_of(opening.radius2, distance2);
            density /= 2 * pi;
            const double scattering = r.cosine / pi;
            const double both = scattering * scattering + density * density;
            const double left = scattering * scattering / both, sampled = density * density / both;
            sum += r.weight * r.light * r.light *
                   (left * left + (density > 0 ? sampled * sampled * scattering / density : 0));
        }
        return sum;
    }

    SkyOpenings& table_;
    std::span<const SkyRecord> records_;
    std::span<const SkyOpening> openings_;
    std::vector<std::uint32_t> order_;  // of records, cell by cell
    std::vector<Range> ranges_;         // of order_, by cell
};

SkyOpenings::SkyOpenings(std::span<const SkyRecord> records, std::span<const SkyOpening> openings) {
    Builder(*this, records, openings).build();
}

std::size_t SkyOpenings::memory_bytes() const {
    return cells_.size() * sizeof(Found) + nodes_.size() * sizeof(Node) + numbers_.size() * sizeof(float);
}

std::size_t SkyOpenings::cell_index(const glm::vec3& position, const glm::vec3& normal) const {
    const Node* node = &nodes_[roots_[facing(normal)]];
    while (node->axis < 3)
        node = &nodes_[node->index + (position[static_cast<int>(node->axis)] >= node->split)];
    return node->index;
}

}  // namespace equistream::embree_host
