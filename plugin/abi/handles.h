#pragma once
/// The opaque handles of equistream.h.
#include <plugin/film/film.h>
#include <plugin/film/hidden_layer.h>
#include <plugin/film/rays.h>
#include <plugin/film/used_pixels.h>

#include "settings.h"

#include <memory>
#include <mutex>
#include <string>

struct es_sequence {
    std::shared_ptr<equistream::SequenceWriter> shared;
    equistream::TileSettings tiles;
};

struct es_frame {
    std::shared_ptr<equistream::SequenceWriter> sequence;
    equistream::FrameInfo info;
    equistream::FrameRays rays;
    equistream::Film film;
    std::unique_ptr<equistream::HiddenLayer> hidden;  ///< null in sequences of the first surfaces

    equistream::UsedPixels used_pixels;  ///< of an atlas

    /// The first misuse of a call that returns nothing; es_frame_end reports it.
    mutable std::mutex misuse_mutex;
    mutable std::string misuse;
};
