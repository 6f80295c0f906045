#pragma once
/// What a viewer is sent, block by block, and what becomes of what it sends.
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace equistream::serve {

struct Portion {
    std::size_t bytes = 0;            ///< put into the block; 0: none now
    double due_s = 0;                 ///< when the first of them was due
    std::optional<double> again_s{};  ///< when there will be some, as elapsed time; nothing: the viewer will be woken
    bool ended = false;               ///< there will be no more
    std::string problem{};            ///< not empty: it cannot go on
};

/// Of one viewer. Times are in seconds since it came.
class Feed {
public:
    virtual ~Feed() = default;
    /// Fills `block` with what is due next.
    virtual Portion next(std::span<char> block, double elapsed_s) = 0;
    /// What the viewer has sent, in pieces of any size.
    virtual void hear(std::span<const char>) {}
};

/// What all viewers look at.
class Programme {
public:
    virtual ~Programme() = default;
    /// For a viewer that has come. The programme outlives it.
    virtual std::unique_ptr<Feed> open_feed() = 0;
};

}  // namespace equistream::serve
