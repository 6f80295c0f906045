#pragma once
/// Risks of one eye's pixels, a row at a time.
#include <equistream_client/reliability.h>

#include <memory>
#include <vector>

namespace equistream {

/// One row of every risk, each contiguous.
struct RiskRow {
    explicit RiskRow(int pixels) : width(pixels), samples(std::size_t(pixels) * risk_count) {}
    float* of(Risk risk) { return samples.data() + std::size_t(risk) * std::size_t(width); }
    const float* of(Risk risk) const { return samples.data() + std::size_t(risk) * std::size_t(width); }

    int width = 0;
    std::vector<float> samples;
};

/// What a picture's risks are computed from; borrows its arguments. Rows may be asked for by any number of threads.
class RiskPicture {
public:
    RiskPicture(const SourceView& source, const EyeView& eye, const EyePicture& picture,
                const ReliabilityOptions& options);
    ~RiskPicture();

    bool has_depth() const;
    void row(int y, RiskRow& out) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace equistream
