#include "mitsuba_host.h"

#include <host-adapters/common/host.h>

int main(int argc, char** argv) {
    equistream::mitsuba_host::MitsubaHost host;
    return equistream::render_command::run(argc, argv, host);
}
