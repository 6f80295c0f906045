/* A library that has every function which is asked for and says that it is version 3. */
#include <stdbool.h>
#include <stddef.h>

static int device;

void* oidnNewDevice(int type) {
    return (void)type, &device;
}
int oidnGetDeviceInt(void* of, const char* name) {
    return (void)of, (void)name, 30102;
}
int oidnGetDeviceError(void* of, const char** message) {
    return (void)of, *message = NULL, 0;
}
void oidnSetDeviceInt(void* of, const char* name, int value) {
    (void)of, (void)name, (void)value;
}
void oidnSetDeviceBool(void* of, const char* name, bool value) {
    (void)of, (void)name, (void)value;
}

#define UNUSED(name)                                                                                                   \
    void name(void) {}
UNUSED(oidnCommitDevice)
UNUSED(oidnReleaseDevice)
UNUSED(oidnNewBuffer)
UNUSED(oidnWriteBuffer)
UNUSED(oidnReadBuffer)
UNUSED(oidnReleaseBuffer)
UNUSED(oidnNewFilter)
UNUSED(oidnSetFilterImage)
UNUSED(oidnSetFilterBool)
UNUSED(oidnSetFilterInt)
UNUSED(oidnSetFilterFloat)
UNUSED(oidnCommitFilter)
UNUSED(oidnExecuteFilter)
UNUSED(oidnReleaseFilter)
