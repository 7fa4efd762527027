// Gathers that were interrupted go on where they stopped.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <numeric>

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

    // Gathers the first so many batches. `finish`: there is no more to do.
    Run gather(size_t batches, const std::string& key = "job", bool finish = false) {
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
        if (finish) {
            log.remove();
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
    EXPECT_EQ(gather(3, "job", true).gathered, 0u);
    EXPECT_FALSE(std::filesystem::exists(path_));
}

// A killed process leaves a part of an entry, a failing disk anything.
TEST_F(GatherLogTest, TakesWhatIsWholeAndNothingElse) {
    const Run whole = gather(3);
    const std::string text = this->text();
    // Of the first entry's numbers, which follow the head, each byte; of all else some.
    constexpr size_t kHead = 25, kNumbers = 24;
    std::vector<size_t> places(kNumbers);
    std::iota(places.begin(), places.end(), kHead);
    for (size_t place = 0; place < text.size(); place += text.size() / 37) {
        places.push_back(place);
    }
    for (const size_t size : places) {
        write(text.substr(0, size));
        const Run cut = gather(3);
        EXPECT_TRUE(cut.records == whole.records) << "cut to " << size << " bytes";
        EXPECT_GT(cut.gathered, 0u) << size;
        std::string changed = text;
        changed[size] = static_cast<char>(changed[size] ^ 0x10);
        write(changed);
        EXPECT_TRUE(gather(3).records == whole.records) << "byte " << size << " changed";
        EXPECT_TRUE(this->text() == text || size == 0) << "byte " << size << ": whole again";
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
    const Run run = gather(3, "job", true);
    EXPECT_EQ(run.gathered, 3 * kBatchOfLog);
    ASSERT_EQ(run.warnings.size(), 1u);
    EXPECT_NE(run.warnings[0].find("remove or rename it"), std::string::npos) << run.warnings[0];
    EXPECT_EQ(text(), "dear diary");
}

TEST_F(GatherLogTest, WithoutAFileItGathersAllTheSame) {
    std::filesystem::create_directory(path_);
    const Run run = gather(3, "job", true);
    EXPECT_EQ(run.gathered, 3 * kBatchOfLog);
    ASSERT_EQ(run.warnings.size(), 1u);
    EXPECT_NE(run.warnings[0].find("begin anew"), std::string::npos) << run.warnings[0];
    EXPECT_TRUE(std::filesystem::is_directory(path_));
}

}  // namespace
}  // namespace sheen
