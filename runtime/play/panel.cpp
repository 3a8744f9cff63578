#include "panel.h"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <cmath>

static const char *const keys_text = "left drag      orbit\n"
                                     "right drag     look around\n"
                                     "wheel          nearer, farther\n"
                                     "W A S D Q E    fly (shift: faster)\n"
                                     "F              show everything\n"
                                     "1 to 9         the scene's cameras\n"
                                     "+ -            exposure\n"
                                     "G              fog on, off\n"
                                     "L              scattered light in lightmaps on, off\n"
                                     "Space          stop the time, go on\n"
                                     "P              screenshot (EXR and PNG)\n"
                                     "Tab            panel on, off\n"
                                     "H              this list\n"
                                     "Esc            end\n"
                                     "drop a baked folder to open it";

bool al_panel_create(GLFWwindow *window)
{
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
    ImGui::StyleColorsDark();
    ImGui::GetStyle().WindowRounding = 4;
    if (ImGui_ImplGlfw_InitForOpenGL(window, true)) {
        if (ImGui_ImplOpenGL3_Init("#version 450 core")) return true;
        ImGui_ImplGlfw_Shutdown();
    }
    ImGui::DestroyContext();
    return false;
}

void al_panel_destroy()
{
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
}

bool al_panel_wants_mouse()
{
    return ImGui::GetIO().WantCaptureMouse;
}
bool al_panel_wants_keyboard()
{
    return ImGui::GetIO().WantCaptureKeyboard;
}

/* Direction as azimuth about +y and height, degrees: stays a unit vector. */
static void edit_direction(float vector[3])
{
    float degrees[2] = {std::atan2(vector[0], vector[2]) * 57.29578f,
                        std::asin(std::fmin(1.0f, std::fmax(-1.0f, vector[1]))) * 57.29578f};
    if (!ImGui::DragFloat2("azimuth, height", degrees, 0.5f, -180, 180, "%.1f deg")) return;
    float height = std::fmin(90.0f, std::fmax(-90.0f, degrees[1])) / 57.29578f,
          azimuth = degrees[0] / 57.29578f;
    vector[0] = std::cos(height) * std::sin(azimuth);
    vector[1] = std::sin(height);
    vector[2] = std::cos(height) * std::cos(azimuth);
}

/* Strength and colour apart, so that one drag dims a light without tinting it. */
static void edit_intensity(const char *unit, float intensity[3])
{
    float strength = std::fmax(intensity[0], std::fmax(intensity[1], intensity[2])), before = strength;
    float color[3] = {1, 1, 1};
    for (int i = 0; i < 3 && strength > 0; i++) color[i] = intensity[i] / strength;
    bool changed = ImGui::DragFloat(unit, &strength, 0.01f * (before + 0.1f), 0, 1e9f, "%.4g");
    changed |= ImGui::ColorEdit3("colour", color, ImGuiColorEditFlags_Float);
    for (int i = 0; i < 3 && changed; i++) intensity[i] = std::fmax(0.0f, strength * color[i]);
}

static void show_lights(al_scene *scene)
{
    if (!ImGui::CollapsingHeader("lights", ImGuiTreeNodeFlags_DefaultOpen)) return;
    for (uint32_t i = 0; i < scene->light_count; i++) {
        al_light *light = &scene->lights[i];
        ImGui::PushID((int)i);
        if (ImGui::TreeNodeEx("light", i < 2 ? ImGuiTreeNodeFlags_DefaultOpen : 0, "%s", light->name)) {
            if (light->type == AL_LIGHT_DIRECTIONAL) {
                edit_intensity("W/m2", light->intensity);
                edit_direction(light->vector);
            } else {
                edit_intensity("W/sr", light->intensity);
                ImGui::DragFloat3("position, m", light->vector, 0.01f);
            }
            ImGui::TreePop();
        }
        ImGui::PopID();
    }
}

static void show_picture(al_panel_state *state, const al_scene *scene)
{
    if (!ImGui::CollapsingHeader("picture", ImGuiTreeNodeFlags_DefaultOpen)) return;
    ImGui::SliderFloat("exposure, EV", state->exposure_ev, -10, 10, "%.2f");
    const char *camera = *state->camera >= 0 ? scene->cameras[*state->camera].name : "(free)";
    if (ImGui::BeginCombo("camera", camera)) {
        for (uint32_t i = 0; i < scene->camera_count; i++)
            if (ImGui::Selectable(scene->cameras[i].name, (int)i == *state->camera)) *state->camera = (int)i;
        ImGui::EndCombo();
    }
    if (ImGui::BeginCombo("pass", al_pass_name(state->settings->pass))) {
        for (int i = 0; i < AL_PASS_COUNT; i++)
            if (ImGui::Selectable(al_pass_name((al_pass)i), i == (int)state->settings->pass))
                state->settings->pass = (al_pass)i;
        ImGui::EndCombo();
    }
}

/* Scrubbing stops the time. */
static void show_time(al_panel_state *state)
{
    double length_s = al_runtime_duration_s(state->runtime);
    if (!(length_s > 0) || !ImGui::CollapsingHeader("time", ImGuiTreeNodeFlags_DefaultOpen)) return;
    float time_s = (float)*state->time_s;
    if (ImGui::SliderFloat("time, s", &time_s, 0, (float)length_s, "%.3f")) {
        *state->time_s = time_s;
        *state->paused = true;
    }
    if (ImGui::Button(*state->paused ? "go on" : "stop")) *state->paused = !*state->paused;
}

/* A slider over a setting in which 0 stands for `all`. */
static void edit_count(const char *label, const char *all_format, uint32_t *value, uint32_t most,
                       bool logarithmic)
{
    int shown = (int)(*value ? *value : most);
    const char *format = *value ? "%d" : all_format;
    if (ImGui::SliderInt(label, &shown, 1, (int)most, format, logarithmic ? ImGuiSliderFlags_Logarithmic : 0))
        *value = shown >= (int)most ? 0 : (uint32_t)shown;
}

static void show_quality(al_panel_state *state)
{
    if (!ImGui::CollapsingHeader("accuracy")) return;
    al_settings *s = state->settings;
    uint64_t total = state->load.samples_total;
    if (total)
        edit_count("samples", "all (%d)", &s->sample_limit,
                   (uint32_t)(total < 1000000000 ? total : 1000000000), true);
    int order = (int)s->sh_order;
    if (ImGui::SliderInt("SH order", &order, 0, 8, order ? "%d" : "as baked")) s->sh_order = (uint32_t)order;
    static const char *const legs[] = {"marched", "SH"};
    int leg = (int)s->view_leg;
    if (ImGui::Combo("view leg", &leg, legs, 2)) s->view_leg = (al_view_leg)leg;
    int intervals = (int)(s->interval_count ? s->interval_count : 16);
    if (ImGui::SliderInt("knots", &intervals, 4, 32)) s->interval_count = (uint32_t)intervals;
    float step = s->march_voxels > 0 ? s->march_voxels : 0.5f;
    if (ImGui::SliderFloat("march step, voxels", &step, 0.05f, 4)) s->march_voxels = step;
    int cells = (int)(s->fog_steps ? s->fog_steps : 32);
    if (ImGui::SliderInt("fog, cells a ray", &cells, 1, 256)) s->fog_steps = (uint32_t)cells;
    float surfel = s->surfel_pixels > 0 ? s->surfel_pixels : 4.6f;
    if (ImGui::SliderFloat("surfels, pixels", &surfel, 1, 50, "%.1f", ImGuiSliderFlags_Logarithmic))
        s->surfel_pixels = surfel;
    ImGui::SliderFloat("surfels' margin, m", &s->surfel_margin_m, 0, 10, s->surfel_margin_m > 0 ? "%.2f" : "all");
    const struct {
        const char *label;
        bool *off;
    } parts[] = {{"surface shading", &s->surface_off},
                 {"clip splats at the boundary", &s->clip_off},
                 {"divide by what Gaussians lose", &s->normalise_off},
                 {"shadows", &s->shadows_off},
                 {"level of detail", &s->detail_off},
                 {"background", &s->background_off},
                 {"fog", &s->fog_off},
                 {"light from surfaces in fog", &s->surface_scattering_off},
                 {"scattered light in lightmaps", &s->scattered_off}};
    for (const auto &part : parts) {
        bool on = !*part.off;
        if (ImGui::Checkbox(part.label, &on)) *part.off = !on;
    }
}

/* Light of surfaces that the fog scatters; `baked`: all media keep optical depths. */
static void show_surface_scattering(al_settings *s, bool baked)
{
    if (!ImGui::CollapsingHeader("surfaces into fog")) return;
    bool on = !s->surface_scattering_off, open = !s->shells_closed, blur = !s->blur_off;
    if (ImGui::Checkbox("on", &on)) s->surface_scattering_off = !on;
    ImGui::Checkbox("surfaces hide others", &s->visibility);
    static const char *const legs[] = {"none", "marched", "baked"};
    int leg = s->second_leg_off ? 0 : 1 + (int)s->second_leg;
    if (ImGui::Combo("surface to fog", &leg, legs, baked ? 3 : 2)) {
        s->second_leg_off = leg == 0;
        s->second_leg = leg == 2 ? AL_SECOND_LEG_BAKED : AL_SECOND_LEG_MARCHED;
    }
    float epsilon = s->shell_epsilon_w_m2_sr > 0 ? s->shell_epsilon_w_m2_sr : 0.06f;
    const char *format = s->shell_epsilon_w_m2_sr > 0 ? "%.4g" : "0.06 as shown";
    if (ImGui::SliderFloat("epsilon, W/(m2 sr)", &epsilon, 1e-4f, 1, format, ImGuiSliderFlags_Logarithmic))
        s->shell_epsilon_w_m2_sr = epsilon;
    int levels = (int)(s->shell_levels ? s->shell_levels : 6), shown = (int)s->shown_level;
    if (ImGui::SliderInt("levels", &levels, 1, 7)) s->shell_levels = (uint32_t)levels;
    if (ImGui::SliderInt("level or layer shown", &shown, 0, levels - 1)) s->shown_level = (uint32_t)shown;
    s->shown_level = s->shown_level < (uint32_t)levels ? s->shown_level : (uint32_t)levels - 1;
    if (ImGui::Checkbox("outermost shell open", &open)) s->shells_closed = !open;
    int samples = (int)(s->bounce_samples ? s->bounce_samples : 4);
    if (ImGui::SliderInt("directions a pixel", &samples, 1, 64)) s->bounce_samples = (uint32_t)samples;
    static const char *const weights[] = {"auto", "coloured", "coefficients"};
    int weighing = (int)s->interval_weights;
    if (ImGui::Combo("interval weights", &weighing, weights, 3)) s->interval_weights = (al_interval_weights)weighing;
    if (ImGui::Checkbox("blur", &blur)) s->blur_off = !blur;
    int mips = (int)(s->blur_mips ? s->blur_mips : s->visibility ? 3 : 1);
    if (ImGui::SliderInt("mips of the blur", &mips, 1, 4)) s->blur_mips = (uint32_t)mips;
    ImGui::Checkbox("blur the medium's outline", &s->blur_plain);
}

/* Light and openness of seen surfaces, by the bounced z-buffer. */
static void show_surfaces(al_settings *s)
{
    if (!ImGui::CollapsingHeader("light between surfaces")) return;
    ImGui::Checkbox("one bounce", &s->indirect);
    ImGui::Checkbox("off matt surfaces alone", &s->indirect_lambert);
    ImGui::Checkbox("ambient occlusion", &s->ambient_occlusion);
    static const char *const carriers[] = {"surfels", "surfels, blended", "volumes", "volumes, blended", "screen"};
    int occludes = (int)s->occlusion_carrier, sends = (int)s->indirect_carrier, samples = (int)(s->bounce_samples ? s->bounce_samples : 4);
    if (ImGui::Combo("bounce by", &sends, carriers, AL_CARRIER_COUNT) && sends != AL_CARRIER_VOLUMES_BLENDED)
        s->indirect_carrier = (al_carrier)sends;
    if (ImGui::Combo("occlusion by", &occludes, carriers, AL_CARRIER_COUNT)) s->occlusion_carrier = (al_carrier)occludes;
    if (occludes == AL_CARRIER_SCREEN || sends == AL_CARRIER_SCREEN) {
        int steps = (int)(s->screen_steps ? s->screen_steps : 32);
        if (ImGui::SliderInt("steps", &steps, 1, 256)) s->screen_steps = (uint32_t)steps;
        float thickness = s->screen_thickness_m;
        if (ImGui::InputFloat("thickness, m (0: 1/32)", &thickness) && thickness >= 0) s->screen_thickness_m = thickness;
    }
    if (ImGui::SliderInt("directions", &samples, 1, 64)) s->bounce_samples = (uint32_t)samples;
    float overlap = s->bounce_overlap > 0 ? s->bounce_overlap : 3, radius = s->occlusion_radius_m;
    if (ImGui::SliderFloat("overlap of discs", &overlap, 1, 16)) s->bounce_overlap = overlap;
    if (ImGui::InputFloat("occlusion radius, m (0: no limit)", &radius) && radius >= 0) s->occlusion_radius_m = radius;
    int filter = s->bounce_filter_off ? 0 : (int)(s->bounce_filter ? s->bounce_filter : 2);
    if (ImGui::SliderInt("filter, pixels", &filter, 0, 16)) {
        s->bounce_filter_off = !filter;
        s->bounce_filter = (uint32_t)filter;
    }
    ImGui::Checkbox("even directions", &s->occlusion_uniform);
    int temporal = (int)s->temporal;
    if (ImGui::SliderInt("frames of history", &temporal, 0, 64)) s->temporal = (uint32_t)temporal;
}

static void show_times(const al_panel_state *state)
{
    if (!ImGui::CollapsingHeader("times", ImGuiTreeNodeFlags_DefaultOpen)) return;
    ImGui::Text("frame %.2f ms, %.1f per second", state->frame_ms, 1000 / std::fmax(state->frame_ms, 1e-3));
    double sum = 0;
    for (uint32_t i = 0; i < state->time_count; i++) {
        ImGui::Text("%-20s %8.3f ms", state->times[i].name, state->times[i].ms);
        sum += state->times[i].ms;
    }
    ImGui::Text("%-20s %8.3f ms", "all passes", sum);
    ImGui::Text("%-20s %8.1f MiB", "memory", (double)al_runtime_memory(state->runtime) / 1048576);
    ImGui::Text("%-20s %8llu", "samples drawn", (unsigned long long)al_runtime_samples(state->runtime));
    ImGui::Text("%-20s %8llu", "surfels", (unsigned long long)al_runtime_surfels(state->runtime));
}

static void show_plan(al_runtime *runtime)
{
    if (!ImGui::CollapsingHeader("plan")) return;
    uint32_t count = 0;
    const al_plan_row *rows = al_runtime_plan(runtime, &count);
    for (uint32_t i = 0; i < count; i++) {
        ImGui::TextDisabled(rows[i].needed ? "on " : "off");
        ImGui::SameLine();
        ImGui::TextWrapped("%s: %s", rows[i].step, rows[i].why);
    }
}

static void show_panel(al_panel_state *state)
{
    al_scene *scene = al_runtime_scene(state->runtime);
    ImGui::SetNextWindowPos(ImVec2(8, 8), ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSize(ImVec2(330, 590), ImGuiCond_FirstUseEver);
    ImGui::Begin("airlight");
    ImGui::PushItemWidth(150);
    if (!scene)
        ImGui::TextWrapped("Drop a baked folder into this window.");
    else
        ImGui::TextWrapped("%s", state->folder);
    if (scene && !state->load.complete)
        ImGui::ProgressBar(state->load.samples_total
                               ? (float)state->load.samples_loaded / (float)state->load.samples_total
                               : 0,
                           ImVec2(-1, 0), "loading");
    if (*state->message) ImGui::TextWrapped("%s", state->message);
    if (scene) {
        show_lights(scene);
        show_time(state);
        show_picture(state, scene);
        show_quality(state);
        if (scene->fog_count) show_surface_scattering(state->settings, al_runtime_keeps_depths(state->runtime));
        if (scene->mesh_count) show_surfaces(state->settings);
        show_times(state);
        show_plan(state->runtime);
    }
    ImGui::TextDisabled("H shows the keys");
    ImGui::PopItemWidth();
    ImGui::End();
}

static void show_help()
{
    ImVec2 size = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos(ImVec2(size.x * 0.5f, size.y * 0.5f), ImGuiCond_Always, ImVec2(0.5f, 0.5f));
    ImGui::Begin("keys", nullptr, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse);
    ImGui::TextUnformatted(keys_text);
    ImGui::End();
}

void al_panel_draw(al_panel_state *state)
{
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    show_panel(state);
    if (state->help) show_help();
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}
