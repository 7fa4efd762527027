// What the program says of itself beside --help.
#include "cli_test.h"

namespace sheen {
namespace {

TEST_F(CliTest, manualPagesSayWhatHelpSays) {
    const Outcome page = call("manual render");
    EXPECT_EQ(page.code, 0);
    EXPECT_EQ(page.out.rfind(".TH \"sheen-render\" 1", 0), 0u);
    EXPECT_NE(page.out.find("\n\\fB\\-\\-target\\-error\\fR"), std::string::npos);
    EXPECT_NE(page.out.find("Default: 512x512.\n"), std::string::npos);
    const Outcome program = call("manual");
    EXPECT_NE(program.out.find("\\fBsheen\\-bake\\fR(1)"), std::string::npos);
    EXPECT_NE(program.out.find("0 done, 1 a bug"), std::string::npos);
}

TEST_F(CliTest, manualPagesAreWrittenIntoAFolder) {
    fs::create_directory(file("pages"));
    EXPECT_EQ(call("manual --output pages").out, "");
    EXPECT_EQ(textOf(file("pages/sheen-render.1")), call("manual render").out);
    EXPECT_EQ(textOf(file("pages/sheen.1")), call("manual").out);
    expectError("manual --output none", ExitCode::kEnvironment, "none/sheen.1: cannot write");
    expectError("manual none", ExitCode::kUsage, "none: no such command");
    expectError("manual render --output pages", ExitCode::kUsage, "COMMAND excludes --output");
}

TEST_F(CliTest, completionIsAScriptOfBash) {
    const Outcome script = call("completion");
    EXPECT_EQ(script.code, 0);
    std::ofstream(file("script")) << script.out;
    const std::string check = fmt::format(
        "bash -c 'source \"{}\"; COMP_WORDS=(sheen bake --method \"\"); COMP_CWORD=3; _sheen; "
        "[[ ${{COMPREPLY[*]}} == \"records texels reference\" ]]'",
        file("script"));
    EXPECT_EQ(std::system(check.c_str()), 0);
}

}  // namespace
}  // namespace sheen
