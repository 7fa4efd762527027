// Renders a part of an image.
#pragma once

#include "image/crop.h"
#include "render/render.h"

namespace sheen {

/// What has the part rendered, and pixels around it, as a frame of its own. Usage error where it
/// does not lie in the image.
RenderParams paramsOfPart(const RenderParams& params, const Crop& crop);

/// Renders that part of the image that `params` describe; the frame is of the part's size. What is
/// seen, direct light of punctual lights and all of the reference are the same as in the whole, bit
/// for bit. What is found by chance or by records is not: they lie elsewhere, and it differs within
/// the estimate. Some pixels around are rendered too, since edges, records and filters ask them.
/// Errors as paramsOfPart() and Session::render().
RenderResult renderPart(Session& session, const RenderParams& params, const Crop& crop);

}  // namespace sheen
