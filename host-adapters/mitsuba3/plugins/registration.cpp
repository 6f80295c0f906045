#include "registration.h"

#include <vector>

namespace equistream::mitsuba_host {

namespace {

/// Built on first use: files of one library are initialised in any order.
std::vector<RegisterVariants>& registrations() {
    static std::vector<RegisterVariants> all;
    return all;
}

}  // namespace

Registration::Registration(RegisterVariants register_them) {
    registrations().push_back(register_them);
}

}  // namespace equistream::mitsuba_host

extern "C" MI_EXPORT void init_plugin(std::string_view name, mitsuba::PluginRegisterFn tell) {
    for (const auto register_them : equistream::mitsuba_host::registrations())
        register_them(name, tell);
}
