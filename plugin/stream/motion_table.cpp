#include "motion_table.h"

#include "bits.h"

#include <equistream/error.h>

#include <array>
#include <cstring>
#include <string>

namespace equistream {
namespace {

constexpr const char* place = "motion in the stream's frame data";

/// In single precision: the twist's velocity and angular velocity, what they change by per second, near and far.
using Numbers = std::array<float, 14>;

Numbers numbers_of(const MovingRegion& region) {
    const glm::vec3 v(region.motion.twist.velocity_m_s), w(region.motion.twist.angular_rad_s),
        dv(region.motion.twist_per_second.velocity_m_s), dw(region.motion.twist_per_second.angular_rad_s);
    return {v.x, v.y, v.z, w.x, w.y, w.z, dv.x, dv.y, dv.z, dw.x, dw.y, dw.z, region.near_m, region.far_m};
}

void set_numbers(MovingRegion& region, const Numbers& n) {
    region.motion = {{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}}, {{n[6], n[7], n[8]}, {n[9], n[10], n[11]}}};
    region.near_m = n[12];
    region.far_m = n[13];
}

using Row = std::vector<PixelRun>;

/// A row's runs, by what they differ from those above by: outlines go on much as they were.
void put_row(BitWriter& bits, const Row& row, const Row& above) {
    bits.put_difference(int(row.size()) - int(above.size()));
    int last = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
        if (i < above.size()) {
            bits.put_difference(row[i].begin - above[i].begin);
            bits.put_difference(row[i].end - above[i].end);
        } else {
            bits.put_count(std::uint32_t(row[i].begin - last));
            bits.put_count(std::uint32_t(row[i].end - row[i].begin));
        }
        last = row[i].end;
    }
}

/// Numbers of any size may come: sums are made in 64 bits, and what does not fit is refused.
Row get_row(BitReader& bits, int y, const Row& above, int width) {
    const auto within = [&](std::int64_t value, std::int64_t low) {
        if (value < low || value > width)
            throw WorkError(expected_found(place, "pixels of a row, up to " + std::to_string(width) + ", in order",
                                           std::to_string(value)));
        return int(value);
    };
    const int count = within(std::int64_t(above.size()) + bits.get_difference(), 0);
    Row row;
    int last = 0;
    for (int i = 0; i < count; ++i) {
        PixelRun run{y, 0, 0};
        if (std::size_t(i) < above.size()) {
            run.begin = within(std::int64_t(above[std::size_t(i)].begin) + bits.get_difference(), last);
            run.end = within(std::int64_t(above[std::size_t(i)].end) + bits.get_difference(), run.begin);
        } else {
            run.begin = within(std::int64_t(last) + bits.get_count(), last);
            run.end = within(std::int64_t(run.begin) + bits.get_count(), run.begin);
        }
        last = run.end;
        row.push_back(run);
    }
    return row;
}

void put_runs(BitWriter& bits, const std::vector<PixelRun>& runs) {
    const int first = runs.empty() ? 0 : runs.front().row;
    const int rows = runs.empty() ? 0 : runs.back().row - first + 1;
    bits.put_count(std::uint32_t(first));
    bits.put_count(std::uint32_t(rows));
    Row above, row;
    auto next = runs.begin();
    for (int y = first; y < first + rows; ++y) {
        row.clear();
        for (; next != runs.end() && next->row == y; ++next)
            row.push_back(*next);
        put_row(bits, row, above);
        above.swap(row);
    }
}

std::vector<PixelRun> get_runs(BitReader& bits, int width, int height) {
    const std::uint32_t first = bits.get_count(), rows = bits.get_count();
    if (std::uint64_t(first) + rows > std::uint64_t(height))
        throw WorkError(expected_found(place, "a region in " + std::to_string(height) + " rows",
                                       std::to_string(rows) + " from row " + std::to_string(first)));
    std::vector<PixelRun> runs;
    Row above;
    for (std::uint32_t i = 0; i < rows; ++i) {
        above = get_row(bits, int(first + i), above, width);
        runs.insert(runs.end(), above.begin(), above.end());
    }
    return runs;
}

}  // namespace

std::vector<std::uint8_t> pack_motion_table(const std::vector<MovingRegion>& regions, int width, int height) {
    if (const auto problem = moving_regions_problem(regions, width, height))
        throw InputError("motion: " + *problem);
    std::vector<std::uint8_t> bytes;
    if (regions.empty())
        return bytes;
    bytes.push_back(static_cast<std::uint8_t>(regions.size()));
    for (const MovingRegion& region : regions) {
        const Numbers numbers = numbers_of(region);
        const auto* raw = reinterpret_cast<const std::uint8_t*>(numbers.data());
        bytes.insert(bytes.end(), raw, raw + sizeof numbers);
    }
    BitWriter bits(bytes);
    for (const MovingRegion& region : regions)
        put_runs(bits, region.runs);
    return bytes;
}

std::vector<MovingRegion> unpack_motion_table(std::span<const std::uint8_t> bytes, int width, int height) {
    if (bytes.empty())
        return {};
    std::vector<MovingRegion> regions(bytes[0]);
    const std::size_t head = 1 + regions.size() * sizeof(Numbers);
    if (bytes.size() < head)
        throw WorkError(
            expected_found(place, "at least " + std::to_string(head) + " bytes", std::to_string(bytes.size())));
    for (std::size_t i = 0; i < regions.size(); ++i) {
        Numbers numbers;
        std::memcpy(numbers.data(), bytes.data() + 1 + i * sizeof numbers, sizeof numbers);
        set_numbers(regions[i], numbers);
    }
    BitReader bits(bytes.subspan(head), place);
    for (MovingRegion& region : regions)
        region.runs = get_runs(bits, width, height);
    if (const auto problem = moving_regions_problem(regions, width, height))
        throw WorkError(std::string(place) + ": " + *problem);
    return regions;
}

}  // namespace equistream
