#include "guard.h"
#include "handles.h"
#include "settings.h"

using namespace equistream;

extern "C" {

uint32_t es_abi_version(void) {
    return ES_ABI_VERSION;
}

const char* es_version(void) {
    return EQUISTREAM_VERSION;
}

es_status es_sequence_open(const es_sequence_settings* settings, es_sequence** sequence, es_error* error) {
    if (sequence != nullptr)
        *sequence = nullptr;
    return guarded(error, [&] {
        if (sequence == nullptr)
            throw InputError(expected_found("es_sequence_open: sequence", "a pointer", "NULL"));
        *sequence = new es_sequence{std::make_shared<SequenceWriter>(checked_settings(settings)),
                                    checked_tile_settings(settings)};
    });
}

int es_sequence_has_frame(const es_sequence* sequence, int64_t index) {
    bool kept = false;
    if (sequence != nullptr)
        guarded(nullptr, [&] { kept = sequence->shared->keeps_frame(index); });
    return kept;
}

void es_sequence_close(es_sequence* sequence) {
    delete sequence;
}

}  // extern "C"
