/* The plot page of gtlut check, by gnuplot (gtlut_check.h). */
#include "gtlut_check.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common.h"
#include "host_gnuplot.h"

static const char colours[][8] = {"#1b6ca8", "#d1495b", "#3c8d53", "#e09f3e", "#7b4fa3", "#5f6b76"};
enum { COLOURS = sizeof colours / sizeof *colours, MAX_CURVES = 6 };

/* At most six slices, evenly chosen. */
static size_t curve_slice(const struct check *c, size_t curve, size_t curves)
{
    return curves > 1 ? curve * (c->count - 1) / (curves - 1) : 0;
}

static size_t column_near(const struct check_slice *s, double phi)
{
    size_t best = 0;
    double least = 720;
    for (size_t k = 0; k < s->phi_count; k++) {
        double off = fabs(s->phi_out[k] - phi);
        off = fmin(off, 360 - off);
        if (off < least) {
            least = off;
            best = k;
        }
    }
    return best;
}

static double luminance(const struct check_slice *s, size_t cell)
{
    const double *v = s->rgb[cell];
    return s->state[cell] == CHECK_MISSING ? NAN : 0.2126 * v[0] + 0.7152 * v[1] + 0.0722 * v[2];
}

/* One point of a curve; what was not measured goes into a column of its own. */
static void put_sample(FILE *f, double range[2], const struct check_slice *s, size_t row, size_t column, double sign)
{
    size_t cell = row * s->phi_count + column;
    double y = luminance(s, cell);
    bool measured = s->state[cell] == CHECK_GOOD;
    if (!(y > 0) || !isfinite(y)) {
        fprintf(f, "%g NaN NaN\n", sign * s->theta_out[row]);
        return;
    }
    range[0] = fmin(range[0], y);
    range[1] = fmax(range[1], y);
    fprintf(f, measured ? "%g %g NaN\n" : "%g NaN %g\n", sign * s->theta_out[row], y);
}

/* The plane of incidence: theta_out below 0 on the light's side. */
static void plot_plane(FILE *f, const struct check *c)
{
    size_t curves = c->count < MAX_CURVES ? c->count : MAX_CURVES;
    double range[2] = {INFINITY, 0};
    for (size_t i = 0; i < curves; i++) {
        const struct check_slice *s = &c->slices[curve_slice(c, i, curves)];
        size_t back = column_near(s, 0), front = column_near(s, 180);
        fprintf(f, "$plane%zu << E\n", i);
        for (size_t row = s->theta_count; row-- > 0;)
            put_sample(f, range, s, row, back, -1);
        for (size_t row = 0; row < s->theta_count; row++)
            put_sample(f, range, s, row, front, 1);
        fputs("E\n", f);
    }
    fprintf(f,
            "set title 'Plane of incidence (dotted: not measured)'\n"
            "set xlabel 'θ_{out}, degrees (below 0: the side of the light)'\n"
            "set ylabel 'BRDF, luminance, 1/sr'\nset logscale y\nset format y '10^{%%T}'\nset xrange [-90:90]\n"
            "set yrange [%g:%g]\nset xtics 30\nset key top left\nplot -1 notitle",
            range[1] > 0 ? range[0] / 4 : 0.1, range[1] > 0 ? 4 * range[1] : 1);
    for (size_t i = 0; i < curves; i++)
        fprintf(f,
                ", $plane%zu using 1:2 with lines lw 1.5 lc rgb '%s' title 'θ_{in}= %g°', '' using 1:3 with lines "
                "lw 1.5 dt 3 lc rgb '%s' notitle",
                i, colours[i % COLOURS], c->slices[curve_slice(c, i, curves)].theta_in, colours[i % COLOURS]);
    fputs("\nunset logscale y\nset format y '%g'\n", f);
}

static void plot_albedo(FILE *f, const struct check *c)
{
    double top = 1.3 * fmax(1, check_albedo_max(c));
    fputs("$albedo << E\n", f);
    for (size_t i = 0; i < c->count; i++) {
        const struct check_slice *s = &c->slices[i];
        fprintf(f, "%g %g %g %g %g %g %g\n", s->theta_in, s->albedo_carried[0], s->albedo_carried[1],
                s->albedo_carried[2], s->albedo[0], s->albedo[1], s->albedo[2]);
    }
    fprintf(f,
            "E\nset title 'Albedo over the angle of incidence'\nset xlabel 'θ_{in}, degrees'\nset ylabel "
            "'reflected share'\nset xrange [0:90]\nset yrange [0:%g]\nset key top center horizontal\n"
            "plot 1 with lines dt 2 lc rgb '#888888' title 'all of the light', "
            "$albedo using 1:2 with linespoints pt 7 ps 0.5 lc rgb '#d1495b' title 'R', "
            "'' using 1:3 with linespoints pt 7 ps 0.5 lc rgb '#3c8d53' title 'G', "
            "'' using 1:4 with linespoints pt 7 ps 0.5 lc rgb '#1b6ca8' title 'B'\nset yrange [*:*]\n",
            top);
}

static void plot_reciprocity(FILE *f, const struct check *c)
{
    fprintf(
        f,
        "$pairs << E\n0 \"as stored\" %g\n1 \"divided\" %g\n2 \"multiplied\" %g\nE\n"
        "set title 'Reciprocity error: values as stored, divided, multiplied by cos'\nset xlabel ''\nset ylabel "
        "'relative error'\nset xrange [-0.6:2.6]\nset yrange [0:*]\nunset key\nset boxwidth 0.5\n"
        "plot $pairs using 1:3:xtic(2) with boxes fs solid 0.6 lc rgb '#1b6ca8'\nset yrange [*:*]\nset xtics auto\n",
        c->reciprocity[0], c->reciprocity[1], c->reciprocity[2]);
}

static size_t states_of(size_t count[CHECK_OUTLIER + 1], const struct check_slice *s)
{
    memset(count, 0, (CHECK_OUTLIER + 1) * sizeof *count);
    for (size_t k = 0; k < s->theta_count * s->phi_count; k++)
        count[s->state[k]]++;
    return s->theta_count * s->phi_count - count[CHECK_GOOD];
}

/* Every sample of the slice with the most that are not plainly measured. */
static void plot_states(FILE *f, const struct check *c)
{
    static const struct {
        const char *name, *ink;
    } states[] = {{"measured", "#b0bec5"}, {"extrapolated", "#e09f3e"}, {"filled in", "#7b4fa3"},
                  {"missing", "#000000"},  {"not finite", "#d1495b"},   {"blind spot", "#1b6ca8"},
                  {"outlier", "#e4007c"}};
    size_t worst = 0, most = 0, count[CHECK_OUTLIER + 1];
    for (size_t i = 0; i < c->count; i++)
        if (states_of(count, &c->slices[i]) > most) {
            most = states_of(count, &c->slices[i]);
            worst = i;
        }
    const struct check_slice *s = &c->slices[worst];
    states_of(count, s);
    fprintf(f,
            "set title 'Samples at θ_{in}= %g°'\nset xlabel 'φ_{out}, degrees (0: the side of the light)'\n"
            "set ylabel 'θ_{out}, degrees'\nset xrange [-5:365]\nset yrange [-2:119]\nset xtics 60\nset ytics "
            "0,15,90\n"
            "set key inside top center horizontal maxrows 2\n",
            s->theta_in);
    for (int state = 0; state <= CHECK_OUTLIER; state++) {
        /* Every third row and ninth column of a fine grid shows where there are many. */
        bool thin = count[state] > 5000;
        fprintf(f, "$state%d << E\n-1000 -1000\n", state);
        for (size_t k = 0; k < s->theta_count * s->phi_count; k++)
            if (s->state[k] == state && !(thin && (k / s->phi_count % 3 || k % s->phi_count % 9)))
                fprintf(f, "%g %g\n", s->phi_out[k % s->phi_count], s->theta_out[k / s->phi_count]);
        fputs("E\n", f);
    }
    fputs("plot -1000 notitle", f);
    for (int state = 0; state <= CHECK_OUTLIER; state++)
        if (count[state])
            fprintf(f,
                    ", $state%d with points pt 5 ps %g lc rgb '%s' notitle, -1000 with points pt 5 ps 1.2 lc rgb '%s' "
                    "title '%s'",
                    state, count[state] < 20 ? 0.8 : 0.25, states[state].ink, states[state].ink, states[state].name);
    fputc('\n', f);
}

void check_plot(const struct check *c, const char *title, const char *path)
{
    struct stat st;
    bool folder = !stat(path, &st) && S_ISDIR(st.st_mode);
    const char *dot = strrchr(path, '.');
    if (!folder && !(dot && !strcmp(dot, ".svg")))
        die(EXIT_USAGE, "--plot: '%s' is neither a folder nor does it end in .svg", path);
    if (!c->count)
        die(EXIT_BAD_INPUT, "--plot: no finite samples to draw");
    char *file = folder ? xasprintf("%s/check.svg", path) : xstrdup(path);
    struct gnuplot g;
    gnuplot_begin(&g, file, 1200, 900);
    fputs("set multiplot layout 2,2 title ", g.to);
    gnuplot_text(&g, title);
    fputs(" noenhanced font big margins 0.08,0.97,0.11,0.9 spacing 0.1,0.15\nset grid lc rgb '#dddddd'\n", g.to);
    plot_plane(g.to, c);
    plot_albedo(g.to, c);
    plot_reciprocity(g.to, c);
    plot_states(g.to, c);
    fputs("unset multiplot\n", g.to);
    gnuplot_end(&g);
    free(file);
}
