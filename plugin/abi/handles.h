#pragma once
/// The opaque handles of equistream.h.
#include "film/film.h"
#include "film/rays.h"

#include <equistream/sequence_writer.h>

#include <memory>
#include <mutex>
#include <string>

struct es_sequence {
    std::shared_ptr<equistream::SequenceWriter> shared;
};

struct es_frame {
    std::shared_ptr<equistream::SequenceWriter> sequence;
    equistream::FrameInfo info;
    equistream::FrameRays rays;
    equistream::Film film;

    /// The first misuse of a call that returns nothing; es_frame_end reports it.
    mutable std::mutex misuse_mutex;
    mutable std::string misuse;
};
