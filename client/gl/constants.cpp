#include "constants.h"

#include "../carry/moved_region.h"
#include "../fill/push_pull_pyramid.h"
#include "../reliability/coefficients.h"
#include "../reliability/risks.h"
#include "../reproject/depth_finder.h"
#include "../reproject/gl/eye_targets.h"
#include "../reproject/hiding_surface.h"
#include "../reproject/source_lattice.h"
#include "../reproject/warp.h"

#include <equistream/conventions.h>
#include <equistream/depth_agreement.h>
#include <equistream/formatted.h>
#include <equistream/virtual_image.h>

#include <bit>
#include <span>
#include <string_view>

namespace equistream::gl {

namespace {

class Defines {
public:
    void add(const char* name, double value) {
        const std::string number = formatted("%.9g", value);
        // 1e+09 and 0.5 are numbers of GLSL's as they stand; 8 would be a whole one.
        const bool whole = number.find_first_of(".e") == std::string::npos;
        text_ += formatted("#define %s %s%s\n", name, number.c_str(), whole ? ".0" : "");
    }
    void add_whole(const char* name, int value) { text_ += formatted("#define %s %d\n", name, value); }
    void add(const char* name, PixelOrigin origin) { text_ += formatted("#define %s %du\n", name, int(origin)); }
    void add(const char* name, std::span<const float> values) {
        text_ += formatted("#define %s float[%d](", name, int(values.size()));
        for (std::size_t i = 0; i < values.size(); ++i)
            text_ += formatted("%s%.9g", i == 0 ? "" : ", ", double(values[i]));
        text_ += ")\n";
    }
    void add_bits(const char* name, unsigned bits) {
        text_ += formatted("#define %s uintBitsToFloat(0x%xu)\n", name, bits);
    }
    std::string take() { return std::move(text_); }

private:
    std::string text_;
};

std::string upper_case(std::string_view name) {
    std::string upper(name);
    for (char& c : upper)
        c = c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c;
    return upper;
}

std::string made() {
    Defines d;
    d.add("PI", pi);
    d.add_bits("UNKNOWN", 0x7fc00000u);
    d.add_bits("INFINITE", 0x7f800000u);
    d.add("FAR_DISTANCE_M", far_distance_m);
    d.add("FARTHEST_CARRIED_M", farthest_carried_m);
    d.add("LARGEST_HALF_HEIGHT", largest_half_height);
    d.add("LEAST_REACH_SHARE", least_reach_share);
    d.add("LEAST_WEIGHT", least_weight);
    d.add("LEAST_BEHIND", least_behind);
    d.add("MOST_BEND", most_bend);
    d.add_whole("MOST_EYES", most_eyes);
    d.add_whole("POSITION_BITS", position_bits);
    d.add_whole("POSITION_ONE", position_one);
    d.add_whole("BLOCK_LEVELS", std::countr_zero(unsigned(LatticeBlock::side)));
    d.add_whole("TILE_SHIFT", PullPyramid::tile_levels);
    d.add("LOG2_CORRECTION", log2_correction);
    d.add("MOST_HALVINGS", most_halvings);
    d.add("TWENTIETHS", twentieths);
    d.add("LARGEST_INVERSE_M", largest_inverse_m);
    d.add("LEAST_COSINE2", least_cosine2);
    d.add("LEAST_FACING", least_facing);
    d.add("LEAST_DISTANCE2", least_distance2);
    d.add("LEAST_LENGTH2", least_length2);
    d.add("LEAST_SPECULAR", least_specular);
    d.add("LOSS_TEXTURES", CodingLoss::textures);
    d.add("ENTRIES_PER_UNIT", reliability_model::entries_per_unit);
    d.add_whole("TABLE_SIZE", reliability_model::table_size);
    d.add_whole("RISKS", risk_count);
    for (std::size_t i = 0; i < risk_names.size(); ++i)
        d.add_whole(("RISK_" + upper_case(risk_names[i])).c_str(), int(i));
    d.add_whole("RISK_GROUPS", risk_group_count);
    d.add_whole("GROUP_MIRRORED", int(RiskGroup::mirrored));
    d.add("ORIGIN_GAP", PixelOrigin::gap);
    d.add("ORIGIN_SOURCE", PixelOrigin::source);
    d.add("ORIGIN_PUSH_PULL", PixelOrigin::push_pull);
    return d.take();
}

}  // namespace

const std::string& constants() {
    static const std::string text = made();
    return text;
}

}  // namespace equistream::gl
