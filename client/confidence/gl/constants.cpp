#include <client/confidence/coefficients.h>
#include <client/confidence/reliability.h>
#include <client/gpu/defines.h>

#include <cstddef>
#include <string_view>

namespace equistream::gl {

namespace {

std::string upper_case(std::string_view name) {
    std::string upper(name);
    for (char& c : upper)
        c = c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c;
    return upper;
}

}  // namespace

std::string confidence_constants() {
    Defines d;
    d.add("MAX_INVERSE_M", max_inverse_m);
    d.add("ENTRIES_PER_UNIT", reliability_model::entries_per_unit);
    d.add_whole("TABLE_SIZE", reliability_model::table_size);
    d.add_whole("RISKS", risk_count);
    for (std::size_t i = 0; i < risk_names.size(); ++i)
        d.add_whole(("RISK_" + upper_case(risk_names[i])).c_str(), int(i));
    d.add_whole("RISK_GROUPS", risk_group_count);
    d.add_whole("GROUP_MIRRORED", int(RiskGroup::mirrored));
    return d.take();
}

}  // namespace equistream::gl
