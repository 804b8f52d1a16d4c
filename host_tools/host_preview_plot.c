/* Polar and Cartesian plots of the plane of incidence (host_preview.h). */
#include "host_preview_internal.h"

#include <math.h>

enum { CURVES = 6, STEPS = 720 };
static const double theta_in_step = 15;
static const char colours[CURVES][8] = {"#1b6ca8", "#d1495b", "#3c8d53", "#e09f3e", "#7b4fa3", "#5f6b76"};

struct curve {
    double value[STEPS + 1]; /* luminance at theta_out from -90 (the light's side) to 90 degrees; NAN at the ends */
    enum measurement_mark mark[STEPS + 1];
};

static double angle_of(int i)
{
    return 180.0 * i / STEPS - 90;
}

static void curve_sample(struct curve *out, const struct preview *p, double theta_in)
{
    double l[3], v[3], rgb[3];
    preview_direction(l, theta_in, 0);
    for (int i = 0; i <= STEPS; i++) {
        double theta = angle_of(i);
        preview_direction(v, fabs(theta), theta < 0 ? 0 : 180);
        out->value[i] = NAN;
        out->mark[i] = MEASURED;
        if (i == 0 || i == STEPS)
            continue;
        p->source.value(rgb, p->source.ctx, l, v);
        out->value[i] = preview_luminance(rgb);
        out->mark[i] = preview_mark(p, l, v);
    }
}

/* Columns: angle, value where measured, value where not. Neighbours share their border, so that the line has no gaps. */
static void put_curve(struct gnuplot *g, int number, const struct curve *c, double (*shown)(double))
{
    fprintf(g->to, "$%s%d << E\n", shown ? "polar" : "plane", number);
    for (int i = 0; i <= STEPS; i++) {
        double y = c->value[i];
        bool here = c->mark[i] == MEASURED, beside = i > 0 && (c->mark[i - 1] == MEASURED) != here;
        if (!(y > 0)) {
            fprintf(g->to, "%g NaN NaN\n", angle_of(i));
            continue;
        }
        y = shown ? shown(y) : y;
        if (here && !beside)
            fprintf(g->to, "%g %.5g NaN\n", angle_of(i), y);
        else if (here || beside)
            fprintf(g->to, "%g %.5g %.5g\n", angle_of(i), y, y);
        else
            fprintf(g->to, "%g NaN %.5g\n", angle_of(i), y);
    }
    fputs("E\n", g->to);
}

static void plot_curves(struct gnuplot *g, const char *block, const char *using)
{
    for (int i = 0; i < CURVES; i++)
        fprintf(g->to,
                "%s$%s%d using %s2 with lines lw 1.5 lc rgb '%s' title 'θ_{in} = %g°', '' using %s3 with lines lw 1.5 "
                "dt (2,4) lc rgb '%s' notitle",
                i ? ", " : "plot ", block, i, using, colours[i], i * theta_in_step, using, colours[i]);
    fputc('\n', g->to);
}

/* 1, 2 or 5 times a power of ten, at least x. */
static double round_up(double x)
{
    double power = pow(10, floor(log10(x)));
    return power * (x <= 1.0001 * power ? 1 : x <= 2 * power ? 2 : x <= 5 * power ? 5 : 10);
}

/* Circles at `most` and at the powers of ten below it whose cube root is at least a tenth of the largest. */
static void polar_axes(struct gnuplot *g, double most)
{
    double rim = cbrt(most);
    fprintf(g->to,
            "set polar\nset angles degrees\nset theta top clockwise\nset trange [-90:90]\nset rrange [0:%g]\n"
            "unset border\nset xrange [%g:%g]\nset yrange [0:%g]\nset size ratio 0.5\nunset xtics\nunset ytics\nunset "
            "raxis\nset grid polar 15 lc rgb '#bbbbbb'\nset rtics ('%g' %g",
            rim, -rim, rim, rim, most, rim);
    for (double r = pow(10, ceil(log10(most)) - 1); cbrt(r / most) > 0.1; r /= 10)
        if (cbrt(r / most) < 0.9)
            fprintf(g->to, ", '%g' %g", r, cbrt(r));
    fputs(") font small\n", g->to);
    for (int theta = -90; theta <= 90; theta += 15)
        fprintf(g->to, "set label '%d°' at %g,%g center font small tc rgb '#666666'\n", theta,
                1.06 * rim * sin(theta * 0.017453292519943295), 1.06 * rim * cos(theta * 0.017453292519943295));
}

void preview_plots(const struct preview *p, const char *path)
{
    static struct curve curves[CURVES];
    struct gnuplot g;
    double most = 0, least = INFINITY;
    unsigned marks = 0;
    for (int k = 0; k < CURVES; k++) {
        curve_sample(&curves[k], p, k * theta_in_step);
        for (int i = 1; i < STEPS; i++) {
            marks |= 1u << curves[k].mark[i];
            most = fmax(most, curves[k].value[i]);
            if (curves[k].value[i] > 0)
                least = fmin(least, curves[k].value[i]);
        }
    }
    if (!(most > 0))
        most = least = 1;
    gnuplot_begin(&g, path, 1300, 560);
    for (int k = 0; k < CURVES; k++) {
        put_curve(&g, k, &curves[k], cbrt);
        put_curve(&g, k, &curves[k], NULL);
    }
    fputs("set multiplot title ", g.to);
    gnuplot_text(&g, p->title);
    fprintf(
        g.to,
        " noenhanced font big\nset lmargin at screen 0.035\nset rmargin at screen 0.515\nset tmargin at screen 0.79\n"
        "set bmargin at screen 0.22\nunset key\nset label 20 'Plane of incidence%s' at screen 0.275,0.9 center\n"
        "set label 21 'θ_{out}: below 0 on the side of the light. Distance: cube root of the BRDF’s luminance; "
        "circles: 1/sr' at "
        "screen 0.275,0.1 center font small\n",
        marks & ~(1u << MEASURED) ? " (dotted: not measured)" : "");
    most = round_up(most);
    polar_axes(&g, most);
    plot_curves(&g, "polar", "1:");
    fprintf(g.to,
            "unset polar\nunset label\nset border\nset size noratio\nset lmargin at screen 0.62\nset rmargin at screen "
            "0.98\n"
            "set tmargin at screen 0.9\nset bmargin at screen 0.13\nset key\nset grid nopolar xtics "
            "ytics lc rgb '#dddddd'\n"
            "set xlabel 'θ_{out}, degrees (below 0: the side of the light)'\nset ylabel 'BRDF, luminance, 1/sr'\n"
            "set logscale y\nset format y '10^{%%T}'\nset xrange [-90:90]\nset yrange [%g:%g]\nset xtics 30\nset ytics "
            "auto\nset key "
            "default top left\n",
            least / 2, 2 * most * pow(most / least, 0.3));
    plot_curves(&g, "plane", "1:");
    fputs("unset multiplot\n", g.to);
    gnuplot_end(&g);
}
