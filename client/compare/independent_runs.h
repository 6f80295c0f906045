#pragma once
/// Whether two runs can give a noise-free error: it is one only where the noise of one does not know that of the other.
#include "picture_pairs.h"
#include "scored_picture.h"

namespace equistream {

/// One pair's pictures as read.
struct RunPictures {
    const ScoredPicture &picture, &truth;
};

/// Throws InputError where one file is in both runs.
void require_other_files(const PicturePair& pair);

/// Throws InputError where a picture of run 1 has the samples of one of run 2 or its seed, or where the runs have
/// another number of samples per pixel. Seed and number are the EXR's own, or the source's in the report.json that
/// `play` leaves beside its views; where neither says, nothing is checked. Pictures of one value everywhere hold no
/// noise and may be alike.
void require_independent(const RunPictures& run_1, const RunPictures& run_2);

}  // namespace equistream
