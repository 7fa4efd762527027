#include "cli/manual.h"

#include <algorithm>
#include <vector>

#include "core/error.h"

namespace sheen::cli {
namespace {

// Text as troff has it.
std::string troff(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '\\') {
            out += "\\e";
        } else if (c == '-') {
            out += "\\-";
        } else if (c == '\n') {
            out += "\n.br\n";
        } else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n')) {
            out += std::string("\\&") + c;
        } else {
            out += c;
        }
    }
    return out;
}

// "\fB\-o\fR, \fB\-\-output\fR \fIFILE\fR", or the name of a positional.
std::string heading(const CLI::Option& option) {
    std::string text;
    const auto add = [&](const char* dashes, const std::string& name) {
        text += (text.empty() ? "" : ", ");
        text += "\\fB" + troff(dashes + name) + "\\fR";
    };
    for (const std::string& name : option.get_snames()) {
        add("-", name);
    }
    for (const std::string& name : option.get_lnames()) {
        add("--", name);
    }
    if (text.empty()) {
        return "\\fI" + troff(option.get_name()) + "\\fR";
    }
    const std::string type = option.get_type_name();
    return option.get_items_expected_max() == 0 || type.empty()
               ? text
               : text + " \\fI" + troff(type) + "\\fR";
}

void describe(const CLI::App& app, std::string& page) {
    for (const CLI::Option* option : app.get_options()) {
        page += ".TP\n" + heading(*option) + "\n" + troff(option->get_description()) + "\n";
        if (!option->get_default_str().empty()) {
            page += ".br\nDefault: " + troff(option->get_default_str()) + ".\n";
        }
    }
}

std::string synopsis(const CLI::App& app) {
    std::string text = "[\\fIOPTIONS\\fR]";
    for (const CLI::Option* option : app.get_options()) {
        if (option->get_positional()) {
            const std::string name = "\\fI" + troff(option->get_name()) + "\\fR" +
                                     (option->get_items_expected_max() > 1 ? " ..." : "");
            text += option->get_required() ? " " + name : " [" + name + "]";
        }
    }
    return text;
}

// Opens a page: its name, its title, what it is.
std::string opening(const std::string& name, const std::string& what) {
    return fmt::format(".TH \"{}\" 1 \"\" \"sheen {}\" \"Sheen\"\n.SH NAME\n{} \\- {}\n", name,
                       SHEEN_VERSION, troff(name), troff(what));
}

std::string joined(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) {
        text += (text.empty() ? "" : " ") + word;
    }
    return text;
}

std::vector<std::string> dashedNames(const CLI::Option& option) {
    std::vector<std::string> names;
    for (const std::string& name : option.get_lnames()) {
        names.push_back("--" + name);
    }
    for (const std::string& name : option.get_snames()) {
        names.push_back("-" + name);
    }
    return names;
}

// Of an option whose description lists its values, {a,b,c}; else empty.
std::vector<std::string> valuesOf(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    const size_t open = type.find('{');
    const size_t close = type.find('}');
    if (open == std::string::npos || close == std::string::npos) {
        return {};
    }
    std::string list = type.substr(open + 1, close - open - 1);
    std::replace(list.begin(), list.end(), ',', ' ');
    return {list};
}

}  // namespace

std::vector<const CLI::App*> commandsOf(const CLI::App& program) {
    return program.get_subcommands([](const CLI::App*) { return true; });
}

std::string manualPage(const CLI::App& program, const std::string& command) {
    if (command.empty()) {
        std::string page = opening("sheen", program.get_description());
        page += ".SH SYNOPSIS\n\\fBsheen\\fR \\fICOMMAND\\fR ...\n.SH COMMANDS\n";
        for (const CLI::App* app : commandsOf(program)) {
            page += fmt::format(".TP\n\\fB{0}\\fR\n{1}; see \\fBsheen\\-{0}\\fR(1)\n",
                                troff(app->get_name()), troff(app->get_description()));
        }
        page += ".SH OPTIONS\n";
        describe(program, page);
        return page + ".SH EXIT STATUS\n" + troff(program.get_footer()) + "\n";
    }
    for (const CLI::App* app : commandsOf(program)) {
        if (app->get_name() == command) {
            std::string page = opening("sheen-" + command, app->get_description());
            page += fmt::format(".SH SYNOPSIS\n\\fBsheen {}\\fR {}\n.SH OPTIONS\n", troff(command),
                                synopsis(*app));
            describe(*app, page);
            return page + ".SH EXIT STATUS\n" + troff(program.get_footer()) +
                   "\n.SH SEE ALSO\n\\fBsheen\\fR(1)\n";
        }
    }
    throwUsage("{}: no such command (see sheen --help)", oneLine(command));
}

std::string bashCompletion(const CLI::App& program) {
    std::vector<std::string> first = {"--help", "--version"};
    std::string values, options;
    for (const CLI::App* app : commandsOf(program)) {
        const std::string& command = app->get_name();
        first.push_back(command);
        std::vector<std::string> names;
        for (const CLI::Option* option : app->get_options()) {
            for (const std::string& name : dashedNames(*option)) {
                names.push_back(name);
                const std::vector<std::string> few = valuesOf(*option);
                if (!few.empty()) {
                    values += fmt::format("        \"{} {}\") words=\"{}\" ;;\n", command, name,
                                          joined(few));
                }
            }
        }
        options += fmt::format("            {}) words=\"{}\" ;;\n", command, joined(names));
    }
    return fmt::format(
        R"(# Completion of sheen for bash; made by `sheen completion`.
_sheen() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} command=${{COMP_WORDS[1]}} words=""
    local before=${{COMP_WORDS[COMP_CWORD-1]}}
    case "$command $before" in
{1}    esac
    if [[ $COMP_CWORD -eq 1 ]]; then
        words="{0}"
    elif [[ -z $words && $word == -* ]]; then
        case $command in
{2}        esac
    fi
    COMPREPLY=($(compgen -W "$words" -- "$word"))
}}
complete -o default -F _sheen sheen
)",
        joined(first), values, options);
}

}  // namespace sheen::cli
