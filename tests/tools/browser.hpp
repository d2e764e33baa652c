#pragma once
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "tests/tools/scratch.hpp"

/// Pages in headless Chromium (scripts/setup --browser), drawn by software.
namespace subsoil::sim::test {

inline bool has_browser() { return std::system("command -v chromium >/dev/null 2>&1") == 0; }

inline std::string output_of(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  std::string text;
  std::array<char, 4096> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) text += buffer.data();
  pclose(pipe);
  return text;
}

/// Runs the page at an address; the document as its scripts leave it, and what they print on the console.
inline std::string opened_at(const std::string& address, const Scratch& scratch) {
  return output_of(
      "timeout 300 chromium --headless --no-sandbox --disable-gpu --use-gl=angle --use-angle=swiftshader "
      "--enable-unsafe-swiftshader --disable-quic --no-first-run --disable-background-networking "
      "--disable-component-update --disable-sync --window-size=1400,900 --user-data-dir=" +
      (scratch / "profile").string() + " --virtual-time-budget=30000 --enable-logging=stderr --dump-dom '" + address +
      "' 2>&1");
}

inline std::string opened(const std::filesystem::path& page, const std::string& hash, const Scratch& scratch) {
  return opened_at("file://" + page.string() + hash, scratch);
}

/// The first line that a page has printed on the console, but for remarks of a driver on its own speed; empty: none.
inline std::string console_of(const std::string& out) {
  for (std::size_t at = out.find("CONSOLE"); at != std::string::npos; at = out.find("CONSOLE", at + 1)) {
    const std::string line = out.substr(at, out.find('\n', at) - at);
    if (line.find("GL Driver Message") == std::string::npos) return line;
  }
  return {};
}

/// What a script of the test finds in a page of `show`, `view` or `report`: the value that its `return` gives. `viewer`
/// is the page's own object, of `show` and `view`. Throws with what the browser prints where the page or the script
/// fails.
inline nlohmann::json asked(const std::filesystem::path& page, const std::string& script, const Scratch& scratch) {
  std::string text = text_of(page);
  const std::string end = "</body>";
  text.insert(text.rfind(end), R"(<pre id="answer"></pre><script>
window.addEventListener('load', async () => {
  for (let i = 0; i < 400 && document.documentElement.dataset.ready !== 'yes'; ++i) await new Promise(r => setTimeout(r, 50));
  const viewer = window.subsoil;
  let answer;
  try { answer = await (async () => {)" +
                                   script + R"(})(); } catch (e) { answer = { failure: String(e) }; }
  document.getElementById('answer').textContent = 'ANSWER' +
    btoa(JSON.stringify({ answer, errors: viewer ? viewer.errors : [] }).replace(/[^ -~]/g, '?')) + 'END';
});</script>)");
  const std::filesystem::path asking = scratch / "asking.html";
  write_file(asking, text);
  const std::string out = opened(asking, "", scratch);
  const std::size_t from = out.find(">ANSWER"), until = out.find("END<", from);
  if (from == std::string::npos || until == std::string::npos)
    throw std::runtime_error("no answer: " + out.substr(0, 3000));
  if (const std::string line = console_of(out); !line.empty()) throw std::runtime_error("on the console: " + line);
  std::string answer;
  unsigned word = 0;
  int bits = 0;
  for (std::size_t i = from + 7; i < until && out[i] != '='; ++i) {
    static const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    word = word << 6U | static_cast<unsigned>(letters.find(out[i])), bits += 6;
    if (bits >= 8) bits -= 8, answer += static_cast<char>(word >> static_cast<unsigned>(bits) & 255U);
  }
  const nlohmann::json all = nlohmann::json::parse(answer);
  if (!all["errors"].empty()) throw std::runtime_error("errors of the page: " + all["errors"].dump());
  if (all["answer"].is_object() && all["answer"].contains("failure"))
    throw std::runtime_error("the test's script: " + all["answer"]["failure"].get<std::string>());
  return all["answer"];
}

}  // namespace subsoil::sim::test
