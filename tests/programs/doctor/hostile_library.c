/* A library that crashes or never returns once it is opened, as EQUISTREAM_TEST_DEED says. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

__attribute__((constructor)) static void act(void) {
    const char* deed = getenv("EQUISTREAM_TEST_DEED");
    if (deed != NULL && strcmp(deed, "crash") == 0)
        abort();
    if (deed != NULL && strcmp(deed, "hang") == 0)
        for (;;)
            pause();
}
