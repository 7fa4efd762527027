// Options as callers of the library give them, understood as the program understands its own: the
// same names, ranges, defaults and errors.
#pragma once

#include <memory>
#include <span>

#include "cli/render_options.h"
#include "sheen/sheen_c.h"

namespace sheen::library {

/// What a call is about, and so which options it has.
enum class Call { kScene, kRender, kWrite, kPoints };

/// Options of a call, parsed. `app` is what they point into.
struct Request {
    CLI::App app;
    cli::RenderOptions options;
};

/// An option that is kept.
struct NamedValue {
    std::string name, value;
};
std::vector<NamedValue> namedValues(std::span<const sheen_option> options);

/// `of_scene`: what the scene was loaded with, which the files of its frames tell. Usage error for
/// a name that the call does not have, and for values that cannot be or do not go together.
std::unique_ptr<Request> requestOf(Call call, std::span<const sheen_option> options,
                                   std::span<const NamedValue> of_scene = {});

}  // namespace sheen::library
