#include "host/cli/generate.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/terminal.hpp"
#include "host/base/text.hpp"
#include "host/cli/table.hpp"
#include <cstdio>
#include <filesystem>

namespace crn
{

namespace
{

namespace fs = std::filesystem;

// States where the completion script of each shell is installed below PREFIX/share; PROGRAM stands for the
// program's name.
struct ShellFile {
    const char *shell, *path;
};
constexpr ShellFile shell_files[] = {{"bash", "bash-completion/completions/PROGRAM"},
                                     {"zsh", "zsh/site-functions/_PROGRAM"},
                                     {"fish", "fish/vendor_completions.d/PROGRAM.fish"}};

constexpr char bash_script[] = R"(# bash completion for PROGRAM, written by `PROGRAM --generate bash`
_PROGRAM_complete() {
    local -a line=()
    local last word cut candidate text
    # The line is split at blanks alone: bash would also split at = and at :
    read -ra line <<<"${COMP_LINE:0:COMP_POINT}"
    [[ ${COMP_LINE:0:COMP_POINT} == *[[:blank:]] ]] && line+=("")
    last=${line[-1]}
    word=${COMP_WORDS[COMP_CWORD]}
    [[ $word == [=:] ]] && word=
    cut=${last%"$word"}
    COMPREPLY=()
    while IFS=$'\t' read -r candidate text; do
        case $candidate in
            :files) compopt -o filenames && mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -f -- "$word") ;;
            :folders) compopt -o filenames && mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -d -- "$word") ;;
            :none) ;;
            *) COMPREPLY+=("${candidate#"$cut"}") ;;
        esac
    done < <("${line[0]/#\~/$HOME}" --complete "${line[@]:1}" 2>/dev/null)
}
complete -F _PROGRAM_complete PROGRAM
)";

constexpr char zsh_script[] = R"(#compdef PROGRAM
# zsh completion for PROGRAM, written by `PROGRAM --generate zsh`
_PROGRAM_complete() {
    local line kind output
    local -a described plain
    output=$(${(Q)~words[1]} --complete "${(@Q)words[2,CURRENT-1]}" "${(Q)PREFIX}" 2>/dev/null)
    for line in ${(f)output}; do
        case $line in
            :*) kind=$line ;;
            *$'\t') plain+=("${line%$'\t'}") ;;
            *) described+=("${${line%%$'\t'*}//:/\\:}:${line#*$'\t'}") ;;
        esac
    done
    (( $#described )) && _describe 'PROGRAM' described
    (( $#plain )) && compadd -a plain
    case $kind in
        :files) _files ;;
        :folders) _files -/ ;;
    esac
}
if [[ $funcstack[1] == _PROGRAM ]]; then
    _PROGRAM_complete "$@"
else
    compdef _PROGRAM_complete PROGRAM
fi
)";

constexpr char fish_script[] = R"(# fish completion for PROGRAM, written by `PROGRAM --generate fish`
function __PROGRAM_complete
    set -l words (commandline -opc)
    set -l last (commandline -ct)
    for line in ($words[1] --complete $words[2..-1] "$last" 2>/dev/null)
        switch $line
            case ':none'
            case ':files'
                __fish_complete_path "$last"
            case ':folders'
                __fish_complete_directories "$last" ''
            case '*'
                echo $line
        end
    end
end
complete -c PROGRAM -f -a '(__PROGRAM_complete)'
)";

std::string with_program(std::string text, const std::string &program)
{
    const std::string word = "PROGRAM";
    for (std::size_t at = text.find(word); at != text.npos; at = text.find(word, at + program.size()))
        text.replace(at, word.size(), program);
    return text;
}

void write_page(const CLI::App &app, const fs::path &folder)
{
    write_whole_file((folder / man_file(app)).string(), man_page(app));
    for (const CLI::App *command : commands_of(app)) write_page(*command, folder);
}

void write_share(const CLI::App &app, const fs::path &share)
{
    const fs::path pages = share / "man" / "man1";
    fs::create_directories(pages);
    write_page(app, pages);
    for (const ShellFile &file : shell_files) {
        const fs::path path = share / with_program(file.path, app.get_name());
        fs::create_directories(path.parent_path());
        write_whole_file(path.string(), completion_script(app.get_name(), file.shell));
    }
}

} // namespace

std::string completion_script(const std::string &program, const std::string &shell)
{
    if (shell == "bash") return with_program(bash_script, program);
    if (shell == "zsh") return with_program(zsh_script, program);
    if (shell == "fish") return with_program(fish_script, program);
    return "";
}

int generate(const CLI::App &app, const std::vector<std::string> &words)
{
    const std::string what = words.size() > 1 ? words[1] : "", program = app.get_name();
    const bool has_folder = words.size() == 3;
    if (const std::string script = completion_script(program, what); words.size() == 2 && !script.empty()) {
        std::fputs(script.c_str(), stdout);
        return 0;
    }
    try {
        if (has_folder && what == "man") {
            fs::create_directories(words[2]);
            write_page(app, words[2]);
            return 0;
        }
        if (has_folder && what == "share") {
            write_share(app, words[2]);
            return 0;
        }
    } catch (const std::exception &error) {
        say(stderr, "%s: %s\n", program.c_str(), error.what());
        return 1;
    }
    say(stderr, "%s: --generate needs bash, zsh or fish, or man FOLDER, or share FOLDER\n", program.c_str());
    return 2;
}

} // namespace crn
