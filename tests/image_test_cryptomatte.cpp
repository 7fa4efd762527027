// Masks by name: identifiers, what covers a pixel, and what of it is in a file.
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>

#include "image/exr.h"
#include "test_folder.h"

namespace sheen {
namespace {

using Json = nlohmann::json;

// Of the published test vectors of MurmurHash3 (x86, 32 bits, seed 0).
TEST(Cryptomatte, IdentifiersAreThoseOfTheSpecification) {
    EXPECT_EQ(std::bit_cast<uint32_t>(matteIdentifier("hello")), 0x248bfa47u);
    EXPECT_EQ(std::bit_cast<uint32_t>(matteIdentifier("hello, world")), 0x149bbb7fu);
    // A hash of 0 would be no normal number.
    EXPECT_TRUE(std::isnormal(matteIdentifier("")));
    EXPECT_EQ(std::bit_cast<uint32_t>(matteIdentifier("")), 1u << 23);
}

// Three pixels: nothing, one triangle alone, an edge.
Frame sampleFrame() {
    Frame frame;
    frame.primitive = Image<uint32_t>(3, 1);
    frame.primitive.pixels = {kNoPrimitive, 2, 0};
    for (Image<vec3>* layer : {&frame.direct, &frame.indirect}) {
        *layer = Image<vec3>(3, 1);
    }
    frame.fragments = {{2, 0, 0.25f}, {2, 2, 0.5f}, {2, 1, 0.125f}};
    return frame;
}

const MatteNames kNames{.layer = "CryptoMaterial", .names = {"red", "blue"}, .of = {0, 0, 1}};

TEST(Cryptomatte, RanksAreNamesByWhatTheyCover) {
    const Matte matte = makeMatte(sampleFrame(), kNames);
    ASSERT_EQ(matte.ranks.size(), 1u);
    const float red = matteIdentifier("red"), blue = matteIdentifier("blue");
    EXPECT_EQ(matte.ranks[0].pixels[0], vec4(0.0f));
    EXPECT_EQ(matte.ranks[0].pixels[1], vec4(blue, 1.0f, 0.0f, 0.0f));
    EXPECT_EQ(matte.ranks[0].pixels[2], vec4(blue, 0.5f, red, 0.375f));
    const Json manifest = Json::parse(matte.manifest);
    EXPECT_EQ(manifest.size(), 2u);
    EXPECT_EQ(std::stoul(manifest["red"].get<std::string>(), nullptr, 16),
              std::bit_cast<uint32_t>(red));
}

TEST(Cryptomatte, AFileSaysWhereItsMasksAre) {
    const TestFolder folder;
    const std::string path = (folder.path() / "a.exr").string();
    const Frame frame = sampleFrame();
    const Matte matte = makeMatte(frame, kNames);
    writeExr(path, frame, ExrLayers::kBasic, {}, {&matte, 1});
    const LoadedExr exr = readExr(path);
    EXPECT_EQ(exr.scalars.at("CryptoMaterial00.A").at(2, 0), 0.375f);
    EXPECT_EQ(exr.colors.at("CryptoMaterial00").at(1, 0).x, matteIdentifier("blue"));
    const Imf::InputFile file(path.c_str());
    int attributes = 0;
    for (auto a = file.header().begin(); a != file.header().end(); ++a) {
        const std::string name = a.name();
        if (name.rfind("cryptomatte/", 0) != 0) {
            continue;
        }
        ++attributes;
        const auto& value = dynamic_cast<const Imf::StringAttribute&>(a.attribute()).value();
        const std::string part = name.substr(name.rfind('/') + 1);
        EXPECT_EQ(value, part == "name"         ? "CryptoMaterial"
                         : part == "hash"       ? "MurmurHash3_32"
                         : part == "conversion" ? "uint32_to_float32"
                                                : matte.manifest);
    }
    EXPECT_EQ(attributes, 4);
}

}  // namespace
}  // namespace sheen
