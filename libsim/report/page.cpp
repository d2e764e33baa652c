#include "libsim/report/page.hpp"

#include "libsim/view/page.hpp"

namespace subsoil::sim {

std::string report_page(const std::string& title, const Json& data, const std::string& script,
                        std::vector<std::pair<std::string, Json>> more) {
  return page_text(
      title, data,
      {std::string(view_uplot_css) + "\n" + page_style_css,
       {std::string("/* uPlot\n") + view_uplot_license + "*/\n" + view_uplot_js, view_data_js, page_figures_js, script},
       std::move(more)});
}

}  // namespace subsoil::sim
