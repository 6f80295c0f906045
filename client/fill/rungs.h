#pragma once
#include <equistream_client/fill.h>

namespace equistream {

class SmallRung : public FillRung {
public:
    std::string_view name() const override { return "small"; }
    bool wants_depth() const override { return true; }
    void set_frame(const FillInputs& inputs) override { small_ = inputs.small; }
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;

private:
    const SourceView* small_ = nullptr;
};

class SpreadRung : public FillRung {
public:
    std::string_view name() const override { return "spread"; }
    bool wants_depth() const override { return false; }
    void set_frame(const FillInputs&) override {}
    std::int64_t fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const override;
};

}  // namespace equistream
