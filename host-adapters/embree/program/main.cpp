#include "embree_host.h"

#include <host-adapters/common/host.h>

int main(int argc, char** argv) {
    equistream::embree_host::EmbreeHost host;
    return equistream::render_command::run(argc, argv, host);
}
