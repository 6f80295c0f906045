#pragma once
/// Running a test with each instruction set that this processor has, the scalar loops included.
#include <hwy/targets.h>

#include <cstdint>
#include <vector>

namespace equistream::test {

/// As bits of hwy's targets: all that this processor has.
inline std::vector<std::int64_t> targets_here() {
    std::vector<std::int64_t> targets = {HWY_EMU128};
    hwy::SetSupportedTargetsForTest(0);
    for (const std::int64_t target : {HWY_SSSE3, HWY_SSE4, HWY_AVX2, HWY_AVX3, HWY_NEON})
        if ((hwy::SupportedTargets() & target) != 0)
            targets.push_back(target);
    return targets;
}

/// Only one of them is used while this lives.
class OnlyTarget {
public:
    explicit OnlyTarget(std::int64_t target) {
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
    ~OnlyTarget() {
        hwy::SetSupportedTargetsForTest(0);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
    OnlyTarget(const OnlyTarget&) = delete;
    OnlyTarget& operator=(const OnlyTarget&) = delete;
};

}  // namespace equistream::test
