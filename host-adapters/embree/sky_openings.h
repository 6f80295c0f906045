#pragma once
/// Where the sky is seen through windows, doors and holes, learned before the first frame, so that light samples of the
/// sky go there.
///
/// Openings are balls that cover what rays leave a building through. The surfaces of a scene are sorted into cells,
/// boxes of a k-d tree over those that face alike. A cell lists the openings that light it and their shares of its
/// skylight. A sample chooses one by its share, and a direction uniform in the cone that the ball fills as seen from
/// the very point. So a list stays apt all over a large cell, where a table of directions would blur.
///
/// Learning: paths from the head's places record where they scatter and what sky they see. Later paths follow what
/// earlier ones found, as path guiding does (Mueller, Gross, Novak, "Practical Path Guiding for Efficient
/// Light-Transport Simulation", 2017). A ball for a light that is sampled by its cone is Shirley, Wang, Zimmerman,
/// "Monte Carlo Techniques for Direct Lighting Calculations", 1996.
///
/// Use: multiple importance sampling with the BSDF, less often where little skylight is to be found. A wrong list costs
/// noise, never light: what no list has is left to BSDF sampling, and a scene that moves on is only sampled less well.
/// Cells that gain nothing have no list.
///
/// Immutable once made; any number of threads may read. Less than a MiB; 40 MiB while it learns.
#include "directions.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace equistream::embree_host {

struct TracedScene;

struct SkyOpening {
    glm::vec3 centre{0};
    float radius2 = 0;  ///< squared
    float share = 0;    ///< of the skylight of its list
};

/// Openings to choose from. Borrows the numbers that it is made of.
class OpeningList {
public:
    OpeningList() = default;
    explicit OpeningList(std::span<const float> numbers) : numbers_(numbers), count_(numbers.size() / 5) {}
    /// Appends the numbers of `openings`, whose shares add up to 1.
    static void append(std::span<const SkyOpening> openings, std::vector<float>& numbers);

    bool empty() const { return count_ == 0; }
    /// Unit.
    glm::vec3 sample(const glm::vec3& from, glm::vec2 u) const;
    /// Of a unit direction, per steradian; 0 for an empty list.
    float pdf(const glm::vec3& from, const glm::vec3& direction) const;

private:
    const float* row(std::size_t which) const { return numbers_.data() + which * count_; }

    std::span<const float> numbers_;  // all x, all y, all z, all squared radii, all sums of shares up to each
    std::size_t count_ = 0;
};

/// Where a training path scattered.
struct SkyRecord {
    glm::vec3 position{0};
    PackedDirection normal, direction;  ///< `direction`: where the path goes on
    float cosine = 0;                   ///< between the two
    float weight = 0;                   ///< cosine / pi over the density that chose `direction`
    float light = 0;                    ///< luminance of the sky in `direction`; 0 where something hides it
    bool goes_on = false;               ///< false: nothing was recorded
};

class SkyOpenings {
public:
    struct Cell {
        OpeningList list;
        float skylight = 0;  ///< irradiance, over the mean of all cells
    };

    SkyOpenings() = default;
    /// `openings` are what cells choose from.
    SkyOpenings(std::span<const SkyRecord> records, std::span<const SkyOpening> openings);

    bool empty() const { return cells_.empty(); }
    Cell at(const glm::vec3& position, const glm::vec3& normal) const {
        const Found& c = cells_[cell_index(position, normal)];
        return {OpeningList(std::span(numbers_).subspan(c.first, c.count)), c.skylight};
    }

    std::size_t cells() const { return cells_.size(); }
    std::size_t memory_bytes() const;
    /// Variance of direct skylight without openings over that with them, as the records have it.
    double gain() const { return gain_; }

private:
    struct Node {
        float split = 0;
        std::uint32_t axis = 3;   // 3: a cell
        std::uint32_t index = 0;  // of the cell, or of the lower child; the upper one is next to it
    };
    struct Found {
        std::uint32_t first = 0, count = 0;  // in numbers_
        float skylight = 0;
    };
    class Builder;
    std::size_t cell_index(const glm::vec3& position, const glm::vec3& normal) const;

    std::array<std::uint32_t, 6> roots_{};  // by the axis that a normal is closest to
    std::vector<Node> nodes_;
    std::vector<Found> cells_;
    std::vector<float> numbers_;
    double gain_ = 1;
};

/// Learns on `threads` threads from paths that begin at `eyes`, the same whatever the threads. Empty where that gains
/// less than it costs, as under an open sky.
SkyOpenings learn_openings(const TracedScene& scene, std::span<const glm::vec3> eyes, unsigned threads);

}  // namespace equistream::embree_host
