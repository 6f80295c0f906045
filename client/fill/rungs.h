#pragma once
#include <equistream_client/fill.h>

namespace equistream {

class SmallRung : public FillRung {
public:
    std::string_view name() const override { return "small"; }
    bool wants_depth() const override { return true; }
    void set_small(const std::optional<SourceView>& small) override { small_ = small; }
    std::int64_t fill(const EyeView& eye, EyePicture& picture) const override;

private:
    std::optional<SourceView> small_;
};

class SpreadRung : public FillRung {
public:
    std::string_view name() const override { return "spread"; }
    bool wants_depth() const override { return false; }
    void set_small(const std::optional<SourceView>&) override {}
    std::int64_t fill(const EyeView& eye, EyePicture& picture) const override;
};

}  // namespace equistream
