#include "cli/render_wanted.h"

#include <filesystem>
#include <utility>

#include "render/crop.h"
#include "render/record_file.h"

namespace sheen::cli {

RenderResult renderWanted(Session& session, const Scene& scene, const RenderOptions& o) {
    const auto render = [&] {
        return o.part ? renderPart(session, o.params, *o.part) : session.render(o.params);
    };
    if (o.cache.empty()) {
        return render();
    }
    const RecordOrigin origin = {sceneFingerprint(scene), recordRecipe(o.params)};
    KeptRecords kept;
    if (std::filesystem::exists(o.cache)) {
        kept = loadRecords(o.cache, origin);
    }
    session.keepRecords(std::move(kept), origin.recipe);
    RenderResult result = render();
    saveRecords(o.cache, session.records(), origin);
    return result;
}

}  // namespace sheen::cli
