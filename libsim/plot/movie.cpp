#include "libsim/plot/movie.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <sstream>
#include <stdexcept>

#include "libsim/io/atomic_file.hpp"
#include "libsim/plot/gnuplot.hpp"
#include "libsim/plot/program.hpp"
#include "libsim/plot/section_film.hpp"
#include "libsim/plot/strip.hpp"

namespace subsoil::sim {
namespace {

/// A folder beside the film that goes with all that is in it.
class PictureFolder {
 public:
  explicit PictureFolder(const std::filesystem::path& film) : path_(film.string() + ".pictures") {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  PictureFolder(const PictureFolder&) = delete;
  PictureFolder& operator=(const PictureFolder&) = delete;
  ~PictureFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  void add(const std::string& script) { run_gnuplot(script, path_ / fmt::format("{:06}.png", count_++), false); }
  std::size_t count() const { return count_; }
  std::string pattern() const { return (path_ / "%06d.png").string(); }
  std::filesystem::path log() const { return path_ / "ffmpeg.log"; }

 private:
  std::filesystem::path path_;
  std::size_t count_ = 0;
};

std::vector<std::string> codec_of(const std::filesystem::path& out) {
  const std::string suffix = out.extension().string();
  if (suffix == ".mp4") return {"-c:v", "libx264", "-crf", "20"};
  if (suffix == ".webm") return {"-c:v", "libvpx-vp9", "-crf", "32", "-b:v", "0"};
  throw std::invalid_argument("--movie: its suffix must be .mp4 or .webm, not '" + suffix + "'");
}

/// Frames of even sizes, as both codecs want them, in the colours that players know.
void join(const PictureFolder& pictures, const std::filesystem::path& out, double rate) {
  const std::filesystem::path part = temporary_name(out);
  std::vector<std::string> words{
      "ffmpeg", "-nostdin", "-loglevel", "error", "-y", "-framerate", fmt::format("{}", rate)};
  words.insert(words.end(), {"-i", pictures.pattern(), "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:0:0:white"});
  for (const std::string& word : codec_of(out)) words.push_back(word);
  words.insert(words.end(), {"-pix_fmt", "yuv420p", "-f", out.extension().string().substr(1), part.string()});
  if (run_program(words, pictures.log()) != 0) {
    std::ostringstream text;
    text << std::ifstream(pictures.log()).rdbuf();
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    throw std::runtime_error("ffmpeg could not make " + out.string() + ":\n" + text.str());
  }
  put_in_place(out, false);
}

/// `most` of `all`, evenly spread, first and last among them.
std::vector<std::size_t> spread(std::size_t all, std::size_t most) {
  const std::size_t count = std::min(all, most);
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < count; ++k) chosen.push_back(count == 1 ? all - 1 : k * (all - 1) / (count - 1));
  return chosen;
}

std::string name_of_run(const std::filesystem::path& run) {
  const auto whole = std::filesystem::absolute(run).lexically_normal();
  return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
}

/// Pictures of the frames that hold soil; false where there is none, as of machines alone.
bool draw_soil(const std::filesystem::path& run, const MovieOptions& options, PictureFolder& pictures) {
  if (!std::filesystem::exists(run / "run.h5"))
    throw std::invalid_argument(run.string() + " holds no run.h5: is it the result directory of a run with frames?");
  const FramesFile file(run / "run.h5");
  if (file.particles() == 0) return false;
  if (file.times().size() < 2)
    throw std::invalid_argument(
        fmt::format("{} holds {} frame, a film needs two: run with `output: {{frames every: 10 ms}}`",
                    (run / "run.h5").string(), file.times().size()));
  const SectionFilm film(file, spread(file.times().size(), options.most), name_of_run(run), options.width);
  for (std::size_t k = 0; k < film.count(); ++k) pictures.add(film.script(k));
  return true;
}

}  // namespace

bool ffmpeg_found() { return on_path("ffmpeg"); }

void movie(const std::filesystem::path& run, const std::filesystem::path& out, const MovieOptions& options) {
  codec_of(out);
  if (!ffmpeg_found())
    throw std::runtime_error(
        "--movie: ffmpeg joins the pictures, and is not on PATH; install it: apt-get install ffmpeg");
  if (is_still(run))
    throw std::invalid_argument("--movie: " + run.string() + " has no course over time; its picture: subsoil plot " +
                                run.string());
  PictureFolder pictures(out);
  if (!draw_soil(run, options, pictures)) {
    StripOptions strip;
    strip.count = static_cast<int>(std::min<std::size_t>(options.most, 200));
    strip.follow = options.follow;
    strip.width = options.width;
    each_instant(run, strip, [&](const Canvas& picture) { pictures.add(picture.script(".png")); });
  }
  join(pictures, out, options.rate);
}

}  // namespace subsoil::sim
