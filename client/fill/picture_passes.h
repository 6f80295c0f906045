#pragma once
/// Fill passes that look gap pixels up in pictures that were rendered elsewhere.
#include "fill.h"
#include "gaps.h"

#include <equistream/patches.h>

#include <optional>

namespace equistream {

/// The small second-eye view; what it does not resolve may be left to others.
class SmallPass : public FillPass {
public:
    enum class Fills { all_gaps, wide_gaps };

    explicit SmallPass(Fills fills) : fills_(fills) {}
    std::string_view name() const override { return fills_ == Fills::all_gaps ? "small" : "small-wide"; }
    bool wants_depth() const override { return true; }
    void set_frame(const FillInputs& inputs) override { inputs_ = inputs; }
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;

private:
    std::int64_t fill_all(const EyeView& eye, EyePicture& picture, Gaps& gaps) const;

    Fills fills_;
    FillInputs inputs_;
    mutable ObjectPool<SeenPoints> pool_;
};

/// The source's second layer.
class HiddenPass : public FillPass {
public:
    std::string_view name() const override { return "hidden"; }
    bool wants_depth() const override { return true; }
    void set_frame(const FillInputs& inputs) override { inputs_ = inputs; }
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;

private:
    FillInputs inputs_;
    mutable ObjectPool<SeenPoints> pool_;
};

/// Earlier main pictures, the newest first.
class EarlierPass : public FillPass {
public:
    std::string_view name() const override { return "earlier"; }
    bool wants_depth() const override { return true; }
    void set_frame(const FillInputs& inputs) override { inputs_ = inputs; }
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;

private:
    FillInputs inputs_;
    mutable ObjectPool<SeenPoints> pool_;
};

/// Blocks of spheres beside the source's.
class PatchesPass : public FillPass {
public:
    std::string_view name() const override { return "patches"; }
    bool wants_depth() const override { return true; }
    void set_frame(const FillInputs& inputs) override;
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;

private:
    FillInputs inputs_;
    std::optional<PatchSlots> slots_;  ///< of their atlas
    mutable ObjectPool<SeenPoints> pool_;
};

}  // namespace equistream
