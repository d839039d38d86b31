"""An encoder of real pictures that names things by the classes of a classifier of photographs."""
