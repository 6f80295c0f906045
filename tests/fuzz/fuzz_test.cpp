// The fuzz targets without a fuzzer: the same cuts and flips in every build.
#include "target.h"

#include <gtest/gtest.h>

#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#if defined(__SANITIZE_ADDRESS__)
/// Read by the sanitizer as it starts. By default it keeps far more of what was freed than we hold.
extern "C" [[gnu::visibility("default")]] const char* __asan_default_options() {
    return "quarantine_size_mb=16:allocator_release_to_os_interval_ms=100";
}
#endif

namespace equistream::fuzz {

void PrintTo(const Target& target, std::ostream* out) {
    *out << target.name;
}

namespace {

/// Damaged input must not make us ask for memory that it does not hold.
constexpr long max_memory_kib = 1 << 20;

class Damage : public testing::TestWithParam<Target> {
protected:
    static void TearDownTestSuite() {
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        EXPECT_LT(usage.ru_maxrss, max_memory_kib);
    }

    /// Reads it; a find fails the test and says which input it was.
    std::string refusal(Bytes bytes, const std::string& which) const {
        try {
            return refusal_of(GetParam(), bytes);
        } catch (const std::exception& find) {
            ADD_FAILURE() << which << ": " << find.what();
            return find.what();
        }
    }
};

TEST_P(Damage, WholeSeedsAreAccepted) {
    const Seeds seeds = GetParam().seeds();
    ASSERT_FALSE(seeds.empty());
    const int* const reached = GetParam().reached;
    for (std::size_t i = 0; i < seeds.size(); ++i) {
        const int before = reached == nullptr ? -1 : *reached;
        EXPECT_EQ(refusal(seeds[i], "seed " + std::to_string(i)), "") << i;
        EXPECT_GT(reached == nullptr ? 0 : *reached, before) << i << " does not get to what it is there for";
    }
}

TEST_P(Damage, Cut) {
    const Seeds seeds = GetParam().seeds();
    std::size_t all_bytes = 0;
    for (const auto& seed : seeds)
        all_bytes += seed.size();
    // Every byte, where a second is enough for that.
    const std::size_t step = all_bytes / static_cast<std::size_t>(GetParam().rounds) + 1;
    for (std::size_t i = 0; i < seeds.size(); ++i)
        for (std::size_t size = 0; size < seeds[i].size() && !HasFailure(); size += step)
            refusal(Bytes(seeds[i]).first(size), "seed " + std::to_string(i) + " cut to " + std::to_string(size));
}

TEST_P(Damage, Flipped) {
    const Seeds seeds = GetParam().seeds();
    std::mt19937 random(17);
    for (int round = 0; round < GetParam().rounds && !HasFailure(); ++round) {
        std::vector<std::uint8_t> bytes = seeds[random() % seeds.size()];
        // Headers are where lengths are: half the flips fall into the first kilobyte.
        const std::size_t reach = round % 2 == 0 ? bytes.size() : std::min<std::size_t>(bytes.size(), 1024);
        for (int flip = 0; flip <= round % 5; ++flip)
            bytes[random() % reach] ^= static_cast<std::uint8_t>(1u << random() % 8);
        refusal(bytes, "round " + std::to_string(round));
    }
}

/// Of targets whose structure is known.
class StructuredDamage : public Damage {};

TEST_P(StructuredDamage, WrongNumbers) {
    const Seeds seeds = GetParam().seeds();
    std::mt19937 random(23);
    for (int round = 0; round < GetParam().rounds && !HasFailure(); ++round) {
        std::vector<std::uint8_t> bytes = seeds[random() % seeds.size()];
        for (int i = 0; i <= round % 3; ++i)
            GetParam().damage(bytes, random);
        refusal(bytes, "round " + std::to_string(round));
    }
}

/// What libFuzzer kept: the smallest inputs that reach what it had found in its longest run.
TEST_P(Damage, Corpus) {
    const std::filesystem::path corpus = std::filesystem::path(CORPORA) / GetParam().name;
    ASSERT_TRUE(std::filesystem::is_directory(corpus)) << corpus << ": tests/fuzz/run.py makes it";
    int inputs = 0;
    for (const auto& input : std::filesystem::directory_iterator(corpus)) {
        refusal(bytes_of_file(input.path()), input.path().filename().string());
        ++inputs;
    }
    EXPECT_GT(inputs, 0) << corpus;
}

std::string name_of(const testing::TestParamInfo<Target>& test) {
    return std::string(test.param.name);
}

std::vector<Target> structured_targets() {
    std::vector<Target> structured;
    std::ranges::copy_if(targets(), std::back_inserter(structured),
                         [](const Target& target) { return target.damage != nullptr; });
    return structured;
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Damage, testing::ValuesIn(targets().begin(), targets().end()), name_of);
INSTANTIATE_TEST_SUITE_P(Fuzz, StructuredDamage, testing::ValuesIn(structured_targets()), name_of);

}  // namespace
}  // namespace equistream::fuzz
