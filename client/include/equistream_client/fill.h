#pragma once
/// The fill ladder: what each rung does to the pixels that the source did not see. Rungs run in order; each touches
/// only pixels whose origin is gap, and marks those it fills.
///
/// `small`   the small second-eye view: the point that the gap pixel sees is looked up in it, and of the samples
///           around it only those on the same surface count. Exact in position for the eye it was rendered from;
///           the other eye gets what that eye sees too. Without depth: by direction alone.
/// `spread`  the nearest filled neighbours, layer by layer, those at the pixel's own depth before others.
#include <equistream_client/view.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace equistream {

class FillRung {
public:
    virtual ~FillRung() = default;
    virtual std::string_view name() const = 0;
    /// Whether the small view's depth and the eye's depth make this rung better.
    virtual bool wants_depth() const = 0;
    /// The small view of this frame, or nothing when there is none (the rung that needs it then fills nothing).
    virtual void set_small(const std::optional<SourceView>& small) = 0;
    /// Fills gaps of `picture`, which shows `eye`; returns how many pixels it filled.
    virtual std::int64_t fill(const EyeView& eye, EyePicture& picture) const = 0;
};

std::span<const std::string_view> fill_rung_names();

/// Rungs of a comma-separated list; "none" alone is an empty ladder. Throws InputError naming the accepted words.
std::vector<std::unique_ptr<FillRung>> make_fill_ladder(const std::string& list);

}  // namespace equistream
