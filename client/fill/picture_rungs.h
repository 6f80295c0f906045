#pragma once
/// Rungs that look gap pixels up in pictures that were rendered elsewhere.
#include "seen_points.h"

#include <equistream/patches.h>
#include <equistream_client/fill.h>

#include <optional>

namespace equistream {

/// The small second-eye view; what it does not resolve may be left to others.
class SmallRung : public FillRung {
public:
    enum class Fills { all_gaps, wide_gaps };

    explicit SmallRung(Fills fills) : fills_(fills) {}
    std::string_view name() const override { return fills_ == Fills::all_gaps ? "small" : "small-wide"; }
    bool wants_depth() const override { return true; }
    void set_frame(const FillInputs& inputs) override {
        small_ = inputs.small;
        main_ = inputs.main;
    }
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;

private:
    std::int64_t fill_all(const EyeView& eye, EyePicture& picture, Gaps& gaps) const;

    Fills fills_;
    const SourceView* small_ = nullptr;
    const SourceView* main_ = nullptr;
    mutable Spares<SeenPoints> spares_;
};

/// The source's second layer.
class HiddenRung : public FillRung {
public:
    std::string_view name() const override { return "hidden"; }
    bool wants_depth() const override { return true; }
    void set_frame(const FillInputs& inputs) override {
        hidden_ = inputs.hidden;
        main_ = inputs.main;
    }
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;

private:
    const SourceView* hidden_ = nullptr;
    const SourceView* main_ = nullptr;
    mutable Spares<SeenPoints> spares_;
};

/// Earlier main pictures, the newest first.
class EarlierRung : public FillRung {
public:
    std::string_view name() const override { return "earlier"; }
    bool wants_depth() const override { return true; }
    void set_frame(const FillInputs& inputs) override {
        earlier_ = inputs.earlier;
        main_ = inputs.main;
    }
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;

private:
    std::span<const SourceView> earlier_;
    const SourceView* main_ = nullptr;
    mutable Spares<SeenPoints> spares_;
};

/// Blocks of spheres beside the source's.
class PatchesRung : public FillRung {
public:
    std::string_view name() const override { return "patches"; }
    bool wants_depth() const override { return true; }
    void set_frame(const FillInputs& inputs) override;
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;

private:
    const PatchesView* patches_ = nullptr;
    const SourceView* main_ = nullptr;
    std::optional<PatchIndex> index_;  ///< of their atlas
    mutable Spares<SeenPoints> spares_;
};

}  // namespace equistream
