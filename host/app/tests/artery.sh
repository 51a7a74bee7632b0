# Sourced by tests of lesions: it makes an artery of 3 mm, straight along y, as text for `bake`.
# write_artery STENOSIS_PERCENT [LINE ...] writes $work/artery.csv and $work/scene.toml; the lines are added
# to the lesion.
write_artery() {
    {
        echo branch,name,x_mm,y_mm,z_mm,radius_mm
        for y in 0 20 40 60 80 100 120; do echo "0,artery,0,$y,0,1.5"; done
    } >"$work/artery.csv"
    cat >"$work/scene.toml" <<TOML
[scene]
name = "Artery"
[lumen]
centrelines = ["artery.csv"]
surface_mm = 0.4
tolerance_mm = 0.05
level_max = 2
[tree]
centrelines = ["artery.csv"]
inlet = "artery"
flow_ml_min = { artery = 60 }
[entry]
position_mm = [0, 5, 0]
direction = [0, 1, 0]
[[body]]
name = "lumen"
mesh = "lumen"
material = "blood"
[[lesion]]
name = "plaque"
branch = "artery"
at_mm = 60
length_mm = 12
stenosis_percent = $1
yield_kPa = 300
full_kPa = 300
recoil = 0.3
TOML
    shift
    [ $# = 0 ] || printf '%s\n' "$@" >>"$work/scene.toml"
}
