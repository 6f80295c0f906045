/// equistream-probe NAME: prints what one probe found, as JSON. `equistream doctor` starts it and bears with its end.
#include "probes.h"

#include <equistream/error.h>
#include <equistream/json_text.h>

#include <algorithm>
#include <cstdio>
#include <exception>

int main(int argc, char** argv) {
    using namespace equistream::doctor;
    const auto probe = std::ranges::find(probes, std::string_view(argc == 2 ? argv[1] : ""), &Probe::name);
    if (probe == probes.end()) {
        std::fputs("equistream-probe: expected the name of a probe; equistream doctor runs all\n", stderr);
        return 2;
    }
    Finding finding;
    try {
        finding = probe->find();
    } catch (const equistream::InputError& error) {
        finding.found = error.what();
    } catch (const std::exception& error) {
        finding = {State::broken, error.what(), "", {}};
    }
    std::puts(equistream::json_text(json_of(finding)).c_str());
    return 0;
}
