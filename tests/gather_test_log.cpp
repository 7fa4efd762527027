// Gathers that were interrupted go on where they stopped.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "core/listener.h"
#include "gather/gather_log.h"
#include "gather/gathered_bytes.h"
#include "gather/ray_gather.h"
#include "test_folder.h"
#include "test_light.h"
#include "test_scenes.h"
#include "test_sites.h"

namespace sheen {
namespace {

constexpr size_t kBatchOfLog = 4;

class GatherLogTest : public testing::Test {
  protected:
    // Counts what it is asked for.
    class Counting : public Gatherer {
      public:
        Counting(const OutgoingLight& light, size_t& count)
            : own_(light, {.size = 8}), count_(count) {}
        std::vector<GatheredRecord> gather(std::span<const RecordSite> sites) override {
            count_ += sites.size();
            return own_.gather(sites);
        }

      private:
        RayGatherer own_;
        size_t& count_;
    };

    struct Run {
        std::string records;  // bytes
        size_t gathered = 0;
        std::vector<std::string> warnings = {};
    };

    // Gathers the first so many batches.
    Run gather(size_t batches, const std::string& key = "job") {
        Run run;
        const Listener listener{.progress = {}, .warning = [&](const std::string& warning) {
                                    run.warnings.push_back(warning);
                                }};
        const ListenerScope scope(listener);
        GatherLog log(path_, key);
        const auto gatherer =
            gatherByLog(std::make_unique<Counting>(lit_.light, run.gathered), log);
        for (size_t b = 0; b < batches; ++b) {
            run.records +=
                bytesOf(gatherer->gather(std::span(sites_).subspan(b * kBatchOfLog, kBatchOfLog)));
        }
        return run;
    }
    std::string text() const {
        std::ifstream in(path_, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    }
    void write(const std::string& text) const {
        std::ofstream(path_, std::ios::binary | std::ios::trunc) << text;
    }

    const Scene scene_ = glossyRoom();
    const LitScene lit_{scene_};
    const std::vector<RecordSite> sites_ = sitesInGlossyRoom(3 * kBatchOfLog);
    const TestFolder folder_;
    const std::string path_ = folder_.path() / "log";
};

TEST_F(GatherLogTest, GoesOnWhereItStopped) {
    const Run whole = gather(3);
    EXPECT_EQ(whole.gathered, 3 * kBatchOfLog);
    std::filesystem::remove(path_);
    EXPECT_EQ(gather(2).gathered, 2 * kBatchOfLog);
    const Run rest = gather(3);
    EXPECT_EQ(rest.gathered, kBatchOfLog);
    EXPECT_TRUE(rest.records == whole.records);
    EXPECT_EQ(gather(3).gathered, 0u);
}

// A killed process leaves a part of an entry, a failing disk anything.
TEST_F(GatherLogTest, TakesWhatIsWholeAndNothingElse) {
    const Run whole = gather(3);
    const std::string text = this->text();
    const size_t step = text.size() / 37;
    for (size_t size = 0; size < text.size(); size += step) {
        write(text.substr(0, size));
        const Run cut = gather(3);
        EXPECT_TRUE(cut.records == whole.records) << "cut to " << size << " bytes";
        EXPECT_GT(cut.gathered, 0u) << size;
        std::string changed = text;
        changed[size] = static_cast<char>(changed[size] ^ 0x10);
        write(changed);
        EXPECT_TRUE(gather(3).records == whole.records) << "byte " << size << " changed";
        EXPECT_TRUE(this->text() == text || size == 0) << "it is whole again";
    }
}

TEST_F(GatherLogTest, AnotherJobBeginsAnew) {
    gather(3);
    const Run other = gather(3, "another job");
    EXPECT_EQ(other.gathered, 3 * kBatchOfLog);
    ASSERT_EQ(other.warnings.size(), 1u);
    EXPECT_NE(other.warnings[0].find("begun anew"), std::string::npos) << other.warnings[0];
    EXPECT_EQ(gather(3, "another job").gathered, 0u);
}

TEST_F(GatherLogTest, LeavesFilesOfOtherKindsAlone) {
    write("dear diary");
    const Run run = gather(3);
    EXPECT_EQ(run.gathered, 3 * kBatchOfLog);
    ASSERT_EQ(run.warnings.size(), 1u);
    EXPECT_NE(run.warnings[0].find("is left as it is"), std::string::npos) << run.warnings[0];
    EXPECT_EQ(text(), "dear diary");
}

TEST_F(GatherLogTest, WithoutAFileItGathersAllTheSame) {
    std::filesystem::create_directory(path_);
    const Run run = gather(3);
    EXPECT_EQ(run.gathered, 3 * kBatchOfLog);
    ASSERT_EQ(run.warnings.size(), 1u);
    EXPECT_NE(run.warnings[0].find("cannot be written"), std::string::npos) << run.warnings[0];
}

}  // namespace
}  // namespace sheen
