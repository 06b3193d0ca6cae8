from mafsil.kernels.device.array import DeviceArray as DeviceArray
from mafsil.kernels.device.array import device_array as device_array
from mafsil.kernels.device.driver import driver as driver
